// tests/physics/barenblatt.cpp: beads that spread into a vacuum: overdamped beads against Barenblatt's solution; beads
// with inertia are rejected.
#include <gtest/gtest.h>

#include <cmath>

#include "drover/base/error.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "full_model.hpp"
#include "initial_spectra.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::barenblatt_tests {
namespace {

constexpr double side = 16.0;

/// d_t rho = (E/2 Gamma) lap rho^2, E = Gamma = 1.
Model spreading_beads() {
    return {.fields = {.bead_density = true, .rod_density = false, .bead_velocity = "slaved"},
            .uniform = {.bead_density = 0.6},
            .drag = {.coefficient = 1.0},
            .stiffness = {.beads = 1.0}};
}

/// rho = t^(-1/2) [C - (Gamma/8E) r^2 t^(-1/2)]_+ with C = 1, about the middle of the cell.
double barenblatt(double x, double y, double t) {
    const double r2 = (x - side / 2) * (x - side / 2) + (y - side / 2) * (y - side / 2);
    return std::max(0.0, 1.0 - r2 / (8.0 * std::sqrt(t))) / std::sqrt(t);
}

struct Outcome {
    double error = 0.0;       ///< integral of |rho - exact| over that of rho
    double undershoot = 0.0;  ///< least density over the peak, with its sign turned
    double mass_change = 0.0;
};

/// From t = 1 to t = 3, the edge moving from 2.83 mm to 3.72 mm.
Outcome spread(int n, double dt) {
    Threads threads(1);
    const numerics::Grid grid{n, n, side, side};
    const Model model = spreading_beads();
    const numerics::WholeRate whole = whole_rate(Equations(model), grid, mean_densities(model), threads);
    numerics::Stepper stepper(whole.system, numerics::stepper_table("etdrk2"), dt, 1, threads);
    numerics::Spectra state =
        initial_spectra({.kind = model::StartKind::formula,
                         .formulas = {{"bead_density", {"max(0, 1 - ((x - 8)^2 + (y - 8)^2)/8)"}}}},
                        model, whole.system, 1, threads);
    const double mass = state[0][0].real();
    const int steps = static_cast<int>(std::lround(2.0 / dt));
    for (int i = 0; i < steps; ++i) stepper.step(i * dt, static_cast<std::uint64_t>(i), state);
    numerics::Fields fields(grid, state.count());
    numerics::Transform(grid, whole.system.degree, threads).backward(state, fields);
    double wrong = 0.0, all = 0.0, least = 0.0, most = 0.0;
    for (std::size_t i = 0; i < fields.size; ++i) {
        const double x = side / n * static_cast<double>(i % static_cast<std::size_t>(n)),
                     y = side / n * static_cast<double>(i / static_cast<std::size_t>(n));
        const double exact = barenblatt(x, y, 3.0), found = fields[0][i];
        wrong += std::abs(found - exact);
        all += exact;
        least = std::min(least, found);
        most = std::max(most, found);
    }
    return {.error = wrong / all, .undershoot = -least / most, .mass_change = state[0][0].real() - mass};
}

TEST(BarenblattLong, edge_is_followed_without_a_clamp_at_the_order_of_its_kink) {
    // The edge is a kink: its Fourier series is right to h^2 in the mean, and to h at the edge itself.  dt falls with
    // h, so that the error of time, dt^2 away from the edge, falls with it.
    const Outcome coarse = spread(64, 0.02), middle = spread(128, 0.01), fine = spread(256, 0.005);
    EXPECT_LT(fine.error, 2e-3);
    EXPECT_GT(std::log2(coarse.error / middle.error), 1.5) << coarse.error << ", " << middle.error;
    EXPECT_GT(std::log2(middle.error / fine.error), 1.5) << middle.error << ", " << fine.error;
    EXPECT_LT(fine.undershoot, 5e-3);
    EXPECT_EQ(fine.mass_change, 0.0) << "the mode q = 0 has no rate at all";
}

TEST(Barenblatt, vacuum_is_rejected_if_beads_have_inertia) {
    Threads threads(1);
    const numerics::Grid grid{32, 32, side, side};
    Model model = spreading_beads();
    model.fields.bead_velocity = "dynamic";
    const numerics::WholeRate whole = whole_rate(Equations(model), grid, mean_densities(model), threads);
    numerics::Stepper stepper(whole.system, numerics::stepper_table("etdrk2"), 0.01, 1, threads);
    numerics::Spectra state =
        initial_spectra({.kind = model::StartKind::formula,
                         .formulas = {{"bead_density", {"max(0, 1 - ((x - 8)^2 + (y - 8)^2)/8)"}}}},
                        model, whole.system, 1, threads);
    try {
        stepper.step(0.0, 0, state);
        ADD_FAILURE() << "a vacuum was stepped over";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::run);
        EXPECT_NE(std::string(error.what()).find("fields.bead_velocity = \"slaved\""), std::string::npos)
            << error.what();
    }
}

}  // namespace
}  // namespace drover::physics::barenblatt_tests
