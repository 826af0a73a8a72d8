// tests/physics/anchoring.cpp: a term that is not isotropic, d_t p_y = -W p_y, and terms of fourth order.
#include <gtest/gtest.h>

#include <cmath>

#include "drover/numerics/stepper.hpp"
#include "full_model.hpp"
#include "linear_modes.hpp"
#include "modes.hpp"
#include "physics/rod_bead_model.hpp"
#include "text_terms.hpp"

namespace drover::physics::anchoring_tests {
namespace {

constexpr double strength = 0.7;

/// Order alone with nothing else that decays, or the two-component equations at their isotropic state.
Model uncoupled() {
    return {.fields = {.bead_density = false, .rod_density = false, .bead_velocity = "absent"},
            .relaxation = {.rate = 0.0}};
}
Model coupled() {
    return {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
            .current = {.speed = 0.8, .kind = "density-order"},
            .drag = {.coefficient = 2.0},
            .driving = {.strength = 0.9},
            .stiffness = {.beads = 1.5},
            .relaxation = {.rate = 0.4, .saturation = 1.0},
            .elasticity = {.stiffness = 0.3},
            .weathercock = {.strength = 0.6},
            .pressure = {.rods = 0.5}};
}

Equations with_anchoring(Model model) {
    model.parameters = {{"W", strength}};
    model.text_terms = {text_term("order", {"0", "-W order_y"})};
    return Equations(model);
}

constexpr numerics::Grid grid{16, 16, 8.0, 8.0};

/// The rate at which a wave of p_y decays in a run.
double rate_in_run(const Equations& e, int kx, int ky) {
    Threads threads(1);
    const numerics::WholeRate whole = whole_rate(e, grid, mean_densities(e.model), threads);
    numerics::Spectra state(grid, numerics::components(layout(physics::form(e.model))));
    const std::size_t mode = static_cast<std::size_t>(ky) * numerics::columns(grid) + static_cast<std::size_t>(kx);
    state[physics::form(e.model).polar_order + 1][mode] = 1e-3;
    if (kx == 0)
        state[physics::form(e.model).polar_order + 1]
             [static_cast<std::size_t>(grid.ny - ky) * numerics::columns(grid)] = 1e-3;
    numerics::Stepper stepper(whole.system, numerics::stepper_table("etdrk4"), 0.02, 1, threads);
    for (int n = 0; n < 50; ++n) stepper.step(0.02 * n, static_cast<std::uint64_t>(n), state);
    return std::log(std::abs(state[physics::form(e.model).polar_order + 1][mode]) / 1e-3);
}

TEST(AnchoringLong, decays_at_its_rate_for_waves_in_every_direction) {
    const Equations e = with_anchoring(uncoupled());
    for (const auto& [kx, ky] : {std::pair{2, 0}, std::pair{0, 2}, std::pair{2, 2}}) {
        const numerics::Wavevector q =
            numerics::wavevector(grid, static_cast<std::size_t>(kx), static_cast<std::size_t>(ky));
        EXPECT_NEAR(mode_rates(e, {}, q).real().minCoeff(), -strength, 1e-14);
        // One second of steps of 0.02 s: fourth order in 0.35 * 0.02, the part that the propagator does not take.
        EXPECT_NEAR(rate_in_run(e, kx, ky), -strength, 1e-9) << "mode " << kx << ky;
    }
}

TEST(Anchoring, adds_its_rate_to_the_coupled_equations_in_every_direction) {
    const Equations without{coupled()}, e = with_anchoring(coupled());
    {
        Threads threads(1);
        const numerics::WholeRate whole = whole_rate(e, grid, mean_densities(e.model), threads);
        for (const auto& [kx, ky] : {std::pair{2, 0}, std::pair{0, 2}, std::pair{2, 2}}) {
            const std::size_t mode =
                static_cast<std::size_t>(ky) * numerics::columns(grid) + static_cast<std::size_t>(kx);
            const numerics::Wavevector q =
                numerics::wavevector(grid, static_cast<std::size_t>(kx), static_cast<std::size_t>(ky));
            const UniformPoint rest{};
            const Symbol difference = linear_symbol(e, rest, q) - linear_symbol(without, rest, q);
            EXPECT_NEAR(difference(FieldIndex::polar_order_y, FieldIndex::polar_order_y).real(), -strength, 1e-14);
            EXPECT_NEAR(difference.norm(), strength, 1e-14) << "and nothing else";
            // The solver's right-hand side for a wave of p_y: that of the symbol.
            numerics::Spectra state = uniform_state(physics::form(e.model), grid, rest);
            state[physics::form(e.model).polar_order + 1][mode] = 1e-6;
            if (kx == 0)
                state[physics::form(e.model).polar_order + 1]
                     [static_cast<std::size_t>(grid.ny - ky) * numerics::columns(grid)] = 1e-6;
            const numerics::Spectra rate = whole(0.0, state);
            EXPECT_NEAR(rate[physics::form(e.model).polar_order + 1][mode].real() / 1e-6,
                        linear_symbol(e, rest, q)(FieldIndex::polar_order_y, FieldIndex::polar_order_y).real(), 1e-6);
        }
    }
}

TEST(Symbols, of_fourth_order_are_expanded_to_second) {
    Model rods = coupled();
    rods.fields = {.bead_density = false, .rod_density = true, .bead_velocity = "absent"};
    rods.drag = {};
    rods.driving = {};
    rods.stiffness = {};
    rods.weathercock = {};
    Model plain = rods;
    plain.elasticity.stiffness += 0.3;
    Model higher = rods;
    higher.elasticity.stiffness += 0.3;
    higher.elasticity.bilaplacian = 5.0;
    const Equations with(higher), of_second(plain);
    const StationaryState rest{.name = "isotropic", .point = {}};
    EXPECT_NEAR(long_waves(with, rest).damping_xx(0, 0), long_waves(of_second, rest).damping_xx(0, 0), 1e-13);
    EXPECT_NEAR(effective_coefficients(with, 1.0, 1.0).stiffness_across, 0.6, 1e-13);
}

}  // namespace
}  // namespace drover::physics::anchoring_tests
