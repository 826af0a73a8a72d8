// tests/physics/model.cpp: the linear theory of the rod model against closed forms.
#include "physics/integrated.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drover/base/error.hpp"
#include "drover/numerics/stepper.hpp"
#include "initial_spectra.hpp"
#include "numerics/solvers/fastest_growth.hpp"
#include "physics/rod_bead_model.hpp"
#include "structure.hpp"
#include "whole_rate.hpp"

namespace drover::physics::model_tests {
namespace {

constexpr numerics::Grid grid{32, 32, 20.0, 20.0};

/// Independent rods: p = sigma P, B = u/2, Delta = Dr sigma, a = Dr: a Poisson gas, S = sigma at every q.
Model independent_rods() {
    const double speed = 2.0, diffusion = 0.5, density = 0.3;
    return {.uniform = {.rod_density = density},
            .current = {.speed = speed},
            .relaxation = {.rate = diffusion},
            .elasticity = {},
            .pressure = {.rods = speed / 2.0},
            .diffusion = {},
            .noise = {.order = diffusion * density, .rods = 0.0}};
}

TEST(StructureFactor, of_independent_rods_is_that_of_a_poisson_gas) {
    // Delta/(2 a) = sigma/2 for each component of the order (rods of unit length), u/B times as much for the density.
    const numerics::System system = linear_system(independent_rods(), grid);
    for (const double q : {0.01, 0.5, 4.0}) {
        const StructureFactor s = structure_factor(system, rods_only, q);
        EXPECT_NEAR(s.rods, 0.3, 1e-15);
        EXPECT_NEAR(s.order_along, 0.15, 1e-15);
        EXPECT_NEAR(s.order_across, 0.15, 1e-15);
    }
}

TEST(StructureFactor, of_diffusing_rods_alone_is_their_shot_noise) {
    Model model = independent_rods();
    model.current.speed = model.pressure.rods = 0.0;
    model.diffusion.rods = 0.7;
    model.noise.rods = 2.0 * 0.7 * 0.3;
    EXPECT_NEAR(structure_factor(linear_system(model, grid), rods_only, 1.3).rods, 0.3, 1e-15);
}

TEST(StructureFactor, of_the_order_across_q_is_delta_over_twice_the_rate) {
    Model model = independent_rods();
    model.elasticity = {.stiffness = 0.6, .splay = 5.0};
    const double q = 0.8;
    EXPECT_NEAR(structure_factor(linear_system(model, grid), rods_only, q).order_across,
                0.5 * 0.15 / (0.5 + 0.6 * q * q), 1e-15);
}

TEST(FastestGrowth, is_the_rate_of_the_mean_order_below_the_threshold) {
    Model model = independent_rods();
    model.relaxation.rate = -0.25;
    model.elasticity.stiffness = 1.0;
    const numerics::FastestGrowth growth = numerics::fastest_growth(linear_system(model, grid));
    EXPECT_DOUBLE_EQ(growth.rate, 0.25);
    EXPECT_EQ(growth.q, 0.0);
    model.relaxation.rate = 0.25;
    EXPECT_LT(numerics::fastest_growth(linear_system(model, grid)).rate, 0.0)
        << "the conserved mean density is not a growing mode";
}

TEST(FastestRate, of_rods_that_only_diffuse_is_that_of_the_last_kept_corner) {
    Model model;
    model.relaxation.rate = 0.0;
    model.diffusion.rods = 0.2;
    const double corner = 2.0 * std::acos(-1.0) / 20.0 * 15.0;  // |k| < 16 on each axis
    EXPECT_NEAR(numerics::fastest_rate(linear_system(model, grid)), 0.2 * 2.0 * corner * corner, 1e-12);
}

TEST(ActiveTerms, are_those_with_a_coefficient) {
    Model model;
    model.relaxation.rate = 0.0;
    EXPECT_TRUE(Equations(model).terms().empty());
    model.elasticity.splay = 1.0;
    EXPECT_EQ(Equations(model).terms(), std::vector<std::string>{"elasticity.splay"});
    EXPECT_EQ(written_terms(Equations(model)), std::vector<std::string>{"K1 grad(div p)"});
}

TEST(PlaneWave, of_the_order_moves_the_density_according_to_the_telegraph_equation) {
    // With a = K = 0: d_tt sigma = u B lap sigma.  A standing wave: sigma ~ cos(w t), i p along q ~ (w/(u q)) sin(w
    // t), w^2 = u B q^2.
    Model model = independent_rods();
    model.relaxation.rate = 0.0;
    model.noise = {};
    const numerics::System system = linear_system(model, grid);
    Threads threads(1);
    numerics::Spectra state = initial_spectra(
        {.kind = model::StartKind::mode, .amplitude = 0.01, .component = "rod_density", .mode_x = 2, .mode_y = -1},
        model, system, 1, threads);
    const std::size_t mode = 31 * numerics::columns(grid) + 2;
    ASSERT_DOUBLE_EQ(state[0][mode].real(), 0.005);
    const double q = 2.0 * std::acos(-1.0) / 20.0 * std::sqrt(5.0), frequency = q * std::sqrt(2.0 * 1.0), t = 0.37;
    numerics::Stepper(system, numerics::stepper_table("etdrk2"), t, 1, threads).step(0.0, 0, state);
    EXPECT_NEAR(state[0][mode].real(), 0.005 * std::cos(frequency * t), 1e-16);
    // d_t p = -B grad sigma: p along (2, -1)/sqrt 5 grows as -B i q sigma integrated.
    const double along = -1.0 * q * 0.005 * std::sin(frequency * t) / frequency;
    EXPECT_NEAR(state[1][mode].imag(), along * 2.0 / std::sqrt(5.0), 1e-16);
    EXPECT_NEAR(state[2][mode].imag(), -along / std::sqrt(5.0), 1e-16);
}

TEST(InitialState, random_has_the_requested_deviation_and_the_exact_mean_density) {
    const Model model = independent_rods();
    const numerics::System system = linear_system(model, grid);
    Threads threads(1);
    const numerics::Spectra state =
        initial_spectra({.kind = model::StartKind::random, .amplitude = 0.1}, model, system, 7, threads);
    EXPECT_EQ(state[0][0], numerics::Complex(0.3));
    double variance = 0.0;
    for (std::size_t m = 1; m < state.size; ++m)
        variance += (m % numerics::columns(grid) == 0 ? 1.0 : 2.0) * std::norm(state[1][m]);
    // 961 kept modes of 1024 hold that part of the variance; its relative deviation is sqrt(2/961) = 0.046: four of
    // them.
    EXPECT_NEAR(variance, 0.01 * 961.0 / 1024.0, 0.01 * 0.19);
}

TEST(InitialState, rejects_fields_and_modes_absent_from_the_model_or_grid) {
    const auto check = [](const model::Start& start, const Model& model) {
        const Equations equations(model);
        model::check(start, equations.solver(mean_densities(model)), grid, kept_degree(equations, {}), no_location);
    };
    const Model model = independent_rods();
    EXPECT_THROW(check({.kind = model::StartKind::mode, .component = "bead_density"}, model), Error);
    EXPECT_THROW(check({.kind = model::StartKind::mode, .mode_x = 16}, model), Error);
    EXPECT_NO_THROW(check({.kind = model::StartKind::mode, .mode_x = -15}, model));
    EXPECT_THROW(check({.kind = model::StartKind::file}, model), Error);
    EXPECT_THROW(check({.formulas = {{"rod_density", {"1"}}}}, model), Error);
    Model silent = model;
    silent.noise = {};
    EXPECT_THROW(check({.kind = model::StartKind::stationary}, silent), Error);
}

}  // namespace
}  // namespace drover::physics::model_tests
