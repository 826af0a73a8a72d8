// tests/physics/stationary_spectrum.cpp: the noisy linear model stays in the stationary law of its Lyapunov equation,
// at any step.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "chi_square.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/solvers/fastest_growth.hpp"
#include "physics/rod_bead_model.hpp"
#include "whole_rate.hpp"

namespace drover::physics::stationary_spectrum_tests {
namespace {

using numerics::Complex;

const Model model{.uniform = {.rod_density = 1.0},
                  .current = {.speed = 1.5},
                  .relaxation = {.rate = 0.4},
                  .elasticity = {.stiffness = 0.7, .splay = 0.3},
                  .pressure = {.rods = 0.8},
                  .diffusion = {.rods = 0.05},
                  .noise = {.order = 0.3, .rods = 0.1}};
constexpr numerics::Grid grid{16, 12, 9.0, 7.0};

TEST(ChiSquare, has_the_tails_of_the_tables) {
    EXPECT_NEAR(upper_gamma(0.5, 0.5 * 3.841458820694124), 0.05, 1e-12);
    EXPECT_NEAR(upper_gamma(5.0, 0.5 * 23.209251158954356), 0.01, 1e-12);
    EXPECT_NEAR(upper_gamma(5.0, 0.5 * 3.940299136119), 0.95, 1e-9);
}

/// One mode in independent variables of unit variance: w = f z, with f f^T = S/area, found by forward substitution.
struct Whitened {
    std::array<Complex, 3> z;  // two along q, one across
};

/// A lower-triangular root of a 2 by 2 covariance, by its closed form.
std::array<double, 3> root(const numerics::Block& s) {
    const double a = std::sqrt(s(0, 0)), b = s(1, 0) / a;
    return {a, b, std::sqrt(s(1, 1) - b * b)};
}

Whitened whitened(const numerics::System& system, const numerics::Spectra& state, std::size_t m) {
    const numerics::Wavevector q = numerics::wavevector(grid, m % numerics::columns(grid), m / numerics::columns(grid));
    const double length = std::hypot(q.x, q.y);
    const numerics::IsotropicBlocks rates = system.linear(length), noise = system.noise(length);
    const auto along = root(numerics::stationary_covariance(rates.even, noise.even));
    const double across = std::sqrt(numerics::stationary_covariance(rates.odd, noise.odd)(0, 0));
    const Complex i(0.0, 1.0), sigma = state[0][m], x = state[1][m], y = state[2][m];
    const Complex p_along = i * (q.x * x + q.y * y) / length, p_across = i * (q.x * y - q.y * x) / length;
    const double scale = std::sqrt(numerics::area(grid));
    Whitened result;
    result.z[0] = scale * sigma / along[0];
    result.z[1] = (scale * p_along - along[1] * result.z[0]) / along[2];
    result.z[2] = scale * p_across / across;
    return result;
}

constexpr int realisations = 1500, steps = 4;

/// What the realisations show: their modes, and the sum of squares of the mean order.
struct Sample {
    std::vector<std::size_t> modes = independent_modes(grid, 1);
    Tally tally{modes.size(), 3};
    double mean_order = 0.0;  ///< of two real numbers of variance Delta/(2 a)/area each
};

void add(const numerics::System& system, const numerics::Spectra& state, Sample& sample) {
    for (std::size_t k = 0; k < sample.modes.size(); ++k)
        sample.tally.add(k, whitened(system, state, sample.modes[k]).z);
    const double variance = model.noise.order / (2.0 * model.relaxation.rate) / numerics::area(grid);
    for (const int c : {1, 2}) sample.mean_order += std::norm(state[c][0]) / variance;
    ++sample.tally.realisations;
}

/// Independent realisations from the stationary law, each some steps on.
template <class MakeStepper>
Sample sampled(const numerics::System& system, MakeStepper make_stepper) {
    Sample sample;
    numerics::Stepper stepper = make_stepper();
    numerics::Spectra state(grid, 3);
    for (int r = 0; r < realisations; ++r) {
        numerics::draw_stationary(system,
                                  {.seed = seed + static_cast<std::uint64_t>(r), .stream = Stream::stationary_state},
                                  state);
        state[0][0] = 1.0;
        for (int n = 0; n < steps; ++n)
            stepper.step(n * stepper.dt(), static_cast<std::uint64_t>(r * steps + n), state);
        EXPECT_EQ(state[0][0], Complex(1.0)) << "the mean density is conserved to the last bit";
        add(system, state, sample);
    }
    return sample;
}

TEST(StationarySpectrumStatistics, of_the_noisy_linear_model_is_the_lyapunov_solution_at_any_step) {
    Threads threads(1);
    const numerics::System system = linear_system(model, grid);
    for (const double dt_rate : {0.1, 1.0, 10.0}) {
        const double dt = dt_rate / numerics::fastest_rate(system);
        const Sample sample = sampled(system, [&] {
            return numerics::Stepper(system, numerics::stepper_table("etdrk2"), dt, seed, threads);
        });
        const Verdict found = diagnosis(sample.tally);
        EXPECT_GT(found.min, 1e-3) << "some mode or pair, dt|s|max = " << dt_rate;
        EXPECT_GT(found.whole, 1e-3) << "the whole set, dt|s|max = " << dt_rate;
        EXPECT_GT(two_sided(sample.mean_order, 2.0 * realisations), 1e-3) << "q = 0, dt|s|max = " << dt_rate;
    }
}

// A method that knows the linear part exactly but holds the noise still over a step has (2/z) tanh(z/2) of the
// variance, z = rate dt.  The test must see that.  (At dt|s|max = 0.1 the fastest mode lacks 8 parts in 10^4, which
// this many realisations cannot tell.)
TEST(StationarySpectrumStatistics, of_noise_frozen_over_the_step_fails_the_same_test) {
    Threads threads(1);
    Model plain = model;
    plain.noise.rods = 0.0;
    const numerics::System exact = linear_system(plain, grid);
    const numerics::Transform transform(grid, 1, threads);
    for (const double dt_rate : {1.0, 10.0}) {
        const double dt = dt_rate / numerics::fastest_rate(exact);
        numerics::System frozen = exact;
        frozen.noise = {};
        std::uint64_t drawn = 0;
        frozen.nonlinear = [&](double, const numerics::Spectra&, numerics::Spectra& rate) {
            numerics::Fields force(grid, 3);
            fill_normal({.seed = seed, .stream = Stream::test, .step = drawn++}, 0, 1, force.values);
            const double strength = std::sqrt(plain.noise.order * static_cast<double>(numerics::points(grid)) /
                                              (numerics::area(grid) * dt));
            for (std::size_t i = 0; i < force.size; ++i) {
                force[0][i] = 0.0;
                force[1][i] *= strength;
                force[2][i] *= strength;
            }
            transform.forward(force, rate);
        };
        const Sample sample = sampled(exact, [&] {
            return numerics::Stepper(frozen, numerics::stepper_table("exponential-euler"), dt, seed, threads);
        });
        const Verdict found = diagnosis(sample.tally);
        // At 1 the fastest mode lacks 8 %: three deviations of its own, which the whole set sees and Bonferroni may
        // not.
        EXPECT_LT(std::min(found.whole, found.min), 1e-3) << "dt|s|max = " << dt_rate;
        if (dt_rate == 10.0) {
            EXPECT_LT(std::max(found.whole, found.min), 1e-3);
        }
    }
}

}  // namespace
}  // namespace drover::physics::stationary_spectrum_tests
