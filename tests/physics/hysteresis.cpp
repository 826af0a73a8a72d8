// tests/physics/hysteresis.cpp: a slow ramp across the region where a uniform gas and bands are both stable.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "band_model.hpp"
#include "drover/numerics/transform.hpp"
#include "physics/integrated.hpp"
#include "physics/rod_bead_model.hpp"
#include "travelling_problem.hpp"

namespace drover::physics::hysteresis_tests {
namespace {

// a = threshold - sigma at a mean density of 1: the gas is unstable below threshold = 1 (spinodal), and the binodal of
// the gas, threshold - 1/6, is the mean density at threshold = 7/6: no bands beyond.
constexpr double side = 96.0, spinodal = 1.0, binodal = 7.0 / 6.0;
constexpr numerics::Grid grid{192, 1, side, 4.0};

Model model_at(double threshold) {
    Model model = model_of({.mu = 1.0, .sigma_c = threshold, .b = 1.0, .pressure = 1.0, .advection = 1.0});
    model.uniform.rod_density = 1.0;
    return model;
}

numerics::Spectra band_guess(Threads& threads) {
    numerics::Fields fields(grid, 3);
    double sum = 0.0;
    for (std::size_t i = 0; i < fields.size; ++i) {
        const double x = side / grid.nx * static_cast<double>(i);
        sum += fields[1][i] = 0.29 * (std::tanh((x - 30.0) / 6.0) - std::tanh((x - 60.0) / 4.0));
    }
    for (std::size_t i = 0; i < fields.size; ++i) fields[0][i] = 1.0 + 0.85 * (fields[1][i] - sum / grid.nx);
    numerics::Spectra state(grid, 3);
    numerics::Transform(grid, 3, threads).forward(fields, state);
    return state;
}

/// The largest mode of the order that depends on x, or its mean.
double order_of(const numerics::Spectra& state) {
    double largest = 0.0;
    for (const int component : {1, 2})
        for (const numerics::Complex value : state[component]) largest = std::max(largest, std::abs(value));
    return largest;
}

/// Waits at a threshold for 300 s, from a state with a small disturbance of the order.
void wait_at(double threshold, Threads& threads, numerics::Spectra& state) {
    constexpr double dt = 0.25;
    model::FieldEvolution evolution(integrated(model_at(threshold)), grid,
                                    {.method = "etdrk2", .dt = dt, .tolerance = 0.0, .watches_error = false}, 1,
                                    threads);
    state[1][0] += 1e-3;
    for (std::size_t k = 1; k <= 4; ++k) state[1][k] += std::polar(1e-3, 1.0 * static_cast<double>(k));
    evolution.start(state);
    for (std::int64_t step = 0; step < 1200; ++step) evolution.advance(step, state);
}

TEST(HysteresisLong, ramp_loses_bands_at_their_fold_below_the_binodal_and_regains_order_at_the_spinodal) {
    Threads threads(1);
    TravellingSolver solver({.model = model_at, .parameter = 1.0, .grid = grid, .dealiasing = {}}, threads);
    const TravellingState band = solver.find(band_guess(threads));
    const std::vector<TravellingState> curve = solver.follow(band, 1.3, 80);
    const double fold = std::max_element(curve.begin(), curve.end(), [](const auto& a, const auto& b) {
                            return a.parameter < b.parameter;
                        })->parameter;
    EXPECT_GT(fold, spinodal + 0.05);
    EXPECT_LT(fold, binodal);

    constexpr double increment = 0.01, present = 0.05;
    numerics::Spectra state = band.state;
    double lost = 1.0, regained = 0.0;
    while (lost < binodal + 0.1 && order_of(state) > present) wait_at(lost += increment, threads, state);
    // The last threshold at which the band exists is one increment before; near a fold it vanishes slowly.
    EXPECT_GT(lost, fold - 0.5 * increment);
    EXPECT_LT(lost, fold + 2.5 * increment);
    EXPECT_LT(lost, binodal);
    for (regained = lost; regained > 0.9 && order_of(state) < present;) wait_at(regained -= increment, threads, state);
    // Order grows at the rate spinodal - threshold: by e^5 from its disturbance.
    EXPECT_LE(regained, spinodal);
    EXPECT_GT(regained, spinodal - 0.05);
}

}  // namespace
}  // namespace drover::physics::hysteresis_tests
