// tests/physics/field_evolution.cpp: the adaptive step and the reference density that follows the beads.
#include "physics/integrated.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drover/numerics/transform.hpp"
#include "initial_spectra.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::field_evolution_tests {
namespace {

struct Case {
    Model model;
    numerics::Grid grid;
    model::Start initial;
    numerics::StepControl control;
    double end = 0.0;
};

/// Beads with inertia and rods that drag them, without noise.
Case flock() {
    return {.model = {.fields = {.bead_density = true, .rod_density = false, .bead_velocity = "dynamic"},
                      .uniform = {.bead_density = 1.0},
                      .drag = {.coefficient = 4.0},
                      .driving = {.strength = 4.0},
                      .stiffness = {.beads = 2.0},
                      .relaxation = {.rate = 0.5, .saturation = 2.0},
                      .elasticity = {.stiffness = 1.0},
                      .weathercock = {.strength = 1.5},
                      .advection = {.strength = 0.5}},
            .grid = {.nx = 32, .ny = 32, .lx = 20.0, .ly = 20.0},
            .initial = {.kind = model::StartKind::formula,
                        .formulas = {{"bead_density", {"1 + 0.2 * cos(2*pi*x/20)"}},
                                     {"polar_order_x", {"0.4 + 0.3 * sin(2*pi*y/20)"}},
                                     {"polar_order_y", {"0.3 * cos(2*pi*(x + y)/20)"}}}},
            .control = {.method = "etdrk2", .dt = 0.5},
            .end = 4.0};
}

model::FieldEvolution evolution_of(const Case& run, Threads& threads) {
    return {integrated(run.model), run.grid, run.control, 0, threads};
}

struct Evolved {
    numerics::Spectra state;
    numerics::StepCount count;
    int division = 1;
    std::int64_t reference_changes = 0;
    std::vector<double> saved;
};

Evolved evolve(const Case& run) {
    Threads threads(1);
    model::FieldEvolution evolution = evolution_of(run, threads);
    numerics::Spectra state = initial_spectra(run.initial, run.model, evolution.linear(), 1, threads);
    evolution.start(state);
    const auto steps = static_cast<std::int64_t>(std::lround(run.end / run.control.dt));
    for (std::int64_t step = 0; step < steps; ++step) evolution.advance(step, state);
    return {std::move(state), evolution.stepper().count(), evolution.stepper().division(),
            evolution.reference_changes(), evolution.save()};
}

Evolved reference_of(Case scene) {
    scene.control.method = "etdrk4";
    scene.control.dt /= 64.0;
    scene.control.tolerance = 0.0;
    return evolve(scene);
}

double distance(const numerics::Spectra& a, const numerics::Spectra& b) {
    double wrong = 0.0, size = 0.0;
    for (std::size_t m = 0; m < a.values.size(); ++m) {
        wrong += std::norm(a.values[m] - b.values[m]);
        size += std::norm(b.values[m]);
    }
    return std::sqrt(wrong / size);
}

TEST(AdaptiveStepLong, its_error_decreases_with_the_tolerance_at_the_order_of_the_method) {
    for (const auto& [method, order] : {std::pair{"etdrk2", 2}, {"etdrk4", 4}}) {
        Case scene = flock();
        scene.control.method = method;
        const Evolved exact = reference_of(scene);
        std::vector<double> errors;
        std::vector<std::int64_t> steps;
        for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
            scene.control.tolerance = tolerance;
            const Evolved run = evolve(scene);
            errors.push_back(distance(run.state, exact.state));
            steps.push_back(run.count.accepted);
            // 4 s of steps, more than 100, each with an error of at most the tolerance; no mode grows.
            EXPECT_LT(errors.back(), 100.0 * tolerance) << method << ", tolerance " << tolerance;
        }
        EXPECT_LT(errors[1], errors[0]) << method;
        EXPECT_LT(errors[2], errors[1]) << method;
        // The error is proportional to dt^order: a hundredth of it takes 100^(1/order) times the steps, within two
        // divisions.
        const double expected = std::pow(100.0, 1.0 / order),
                     found = static_cast<double>(steps[2]) / static_cast<double>(steps[1]);
        EXPECT_NEAR(std::log(found), std::log(expected), std::log(2.0))
            << method << ": " << steps[1] << ", " << steps[2];
    }
}

TEST(AdaptiveStep, it_is_divided_for_a_fast_start_and_grows_when_the_run_is_slow) {
    Case scene = flock();
    scene.control.tolerance = 1e-4;
    scene.end = 200.0;
    const Evolved run = evolve(scene);
    EXPECT_GT(run.count.accepted, 120) << "the start needs steps shorter than dt";
    EXPECT_GT(run.count.rejected, 0);
    EXPECT_EQ(run.division, 1) << "the flock is uniform at the end";
}

/// <|p_q|^2> L^2/S of linear theory over the modes of a noisy run, in its standard errors from 1, by bands of q^2.
std::vector<double> deviations_from_linear_theory(const Case& scene, numerics::StepCount& count) {
    Threads threads(1);
    model::FieldEvolution evolution(integrated(scene.model), scene.grid, scene.control, 7, threads);
    numerics::Spectra state = initial_spectra(scene.initial, scene.model, evolution.linear(), 1, threads);
    evolution.start(state);
    const std::vector<double> bands{2.5, 8.5, 1e9};
    std::vector<double> sums(bands.size()), variances(bands.size()), numbers(bands.size());
    const auto steps = static_cast<std::int64_t>(std::lround(scene.end / scene.control.dt)), warm_up = steps / 20;
    const double unit = 2.0 * std::numbers::pi / scene.grid.lx, area = scene.grid.lx * scene.grid.ly;
    for (std::int64_t step = 0; step < steps; ++step) {
        evolution.advance(step, state);
        if (step < warm_up) continue;
        for (std::size_t j = 0; j < static_cast<std::size_t>(scene.grid.ny); ++j)
            for (std::size_t i = 1; i < numerics::columns(scene.grid); ++i) {  // column 0 has conjugate pairs
                if (!numerics::is_kept(scene.grid, evolution.linear().degree, i, j)) continue;
                const double kx = static_cast<double>(i), ky = numerics::mode_number_y(scene.grid, j),
                             squared = kx * kx + ky * ky;
                const double rate =
                    scene.model.relaxation.rate + scene.model.elasticity.stiffness * squared * unit * unit;
                const double expected = scene.model.noise.order / (2.0 * rate);
                const double kept = std::exp(-2.0 * rate * scene.control.dt);  // correlation of |p_q|^2 of two samples
                const std::size_t band = squared < bands[0] ? 0 : squared < bands[1] ? 1 : 2;
                for (int c = 0; c < 2; ++c) {
                    sums[band] += std::norm(state[c][j * numerics::columns(scene.grid) + i]) * area / expected;
                    variances[band] += (1.0 + kept) / (1.0 - kept);  // |p_q|^2 is exponential: variance 1
                    numbers[band] += 1.0;
                }
            }
    }
    count = evolution.stepper().count();
    std::vector<double> result;
    for (std::size_t band = 0; band < bands.size(); ++band)
        result.push_back((sums[band] - numbers[band]) / std::sqrt(variances[band]));
    return result;
}

TEST(AdaptiveStepStatistics, keeps_the_stationary_spectrum_at_every_tolerance) {
    // b <|p|^2>/a is 1e-4, below the errors of 1 %; a step of 1 s must still be divided for the small tolerances.
    Case scene{.model = {.fields = {.rod_density = false},
                         .relaxation = {.rate = 1.0, .saturation = 0.05},
                         .elasticity = {.stiffness = 0.5},
                         .noise = {.order = 0.02}},
               .grid = {.nx = 16, .ny = 16, .lx = 16.0, .ly = 16.0},
               .initial = {},
               .control = {.method = "etdrk2", .dt = 1.0},
               .end = 1000.0};
    for (const double tolerance : {0.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        scene.control.tolerance = tolerance;
        numerics::StepCount count;
        for (const double deviation : deviations_from_linear_theory(scene, count))
            EXPECT_LT(std::abs(deviation), 4.0) << "tolerance " << tolerance;
        EXPECT_TRUE(tolerance != 1e-6 || count.accepted > 2000) << "the steps were not divided";
    }
}

TEST(AdaptiveStep, a_diverging_run_ends_with_a_run_error) {
    Case scene = flock();
    scene.model.relaxation.saturation = 0.0;
    scene.model.relaxation.rate = -3.0;
    scene.control.tolerance = 1e-4;
    scene.end = 4000.0;
    try {
        evolve(scene);
        ADD_FAILURE() << "a field that grows without bound reached the end of the run";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::run) << error.what();
    }
}

TEST(ReferenceDensity, it_falls_with_a_bead_density_below_half_of_it) {
    Case scene = flock();
    scene.initial.formulas["bead_density"] = {"1 + 0.75 * cos(2*pi*x/20)"};
    scene.model.stiffness.beads = 0.3;
    scene.model.drag.coefficient = 4000.0;  // Gamma dt/rho = 400 at the reference, 1600 where the density is low
    scene.model.driving.strength = 4000.0;
    scene.initial.formulas["bead_velocity_x"] =
        scene.initial.formulas["polar_order_x"];  // in balance with the drag: no initial transient
    scene.initial.formulas["bead_velocity_y"] = scene.initial.formulas["polar_order_y"];
    scene.control.dt = 0.1;
    scene.end = 2.0;
    const Evolved run = evolve(scene), fine = reference_of(scene);
    EXPECT_GT(run.reference_changes, 0);
    EXPECT_LT(run.saved[0], 0.0) << "the reference is below the mean";
    EXPECT_LT(distance(run.state, fine.state), 5e-3);  // a few times dt^2 for rates up to one
}

TEST(ReferenceDensityLong, it_rises_with_a_peak_of_slaved_beads) {
    Case scene = flock();
    scene.model = {.fields = {.bead_density = true, .rod_density = false, .bead_velocity = "slaved"},
                   .uniform = {.bead_density = 0.1},
                   .drag = {.coefficient = 1.0},
                   .stiffness = {.beads = 1.0}};
    scene.grid = {.nx = 64, .ny = 64, .lx = 16.0, .ly = 16.0};
    scene.control.dt = 0.02;
    scene.end = 2.0;
    scene.initial = {.kind = model::StartKind::formula,
                     .formulas = {{"bead_density", {"exp(-((x - 8)^2 + (y - 8)^2)/4)"}}}};
    const Evolved run = evolve(scene), fine = reference_of(scene);
    EXPECT_GT(run.saved[0], 0.0)
        << "rho E/Gamma of the peak is ten times that of the mean: the reference is above the mean";
    EXPECT_LT(distance(run.state, fine.state), 1e-3);  // dt^2 for rates of order one
}

TEST(FieldEvolution, the_number_of_beads_is_conserved_through_rejected_steps_and_changes_of_the_reference) {
    Case scene = flock();
    scene.initial.formulas["bead_density"] = {"1 + 0.7 * cos(2*pi*x/20)"};
    scene.control.tolerance = 1e-4;
    scene.end = 40.0;
    const Evolved run = evolve(scene);
    EXPECT_GT(run.count.rejected, 0);
    EXPECT_GT(run.reference_changes, 0);
    // The mode q = 0 has no rate: it keeps its initial value, 1 to the rounding of the first transform.
    EXPECT_NEAR(run.state[0][0].real(), 1.0, 1e-15);
}

TEST(FieldEvolution, a_restored_evolution_continues_bit_for_bit) {
    Case scene = flock();
    scene.initial.formulas["bead_density"] = {"1 + 0.7 * cos(2*pi*x/20)"};
    scene.control.tolerance = 1e-5;
    Threads threads(1);
    model::FieldEvolution first = evolution_of(scene, threads);
    numerics::Spectra state = initial_spectra(scene.initial, scene.model, first.linear(), 1, threads);
    first.start(state);
    for (std::int64_t step = 0; step < 3; ++step) first.advance(step, state);
    model::FieldEvolution second = evolution_of(scene, threads);
    second.restore(first.save());
    numerics::Spectra again = state;
    for (std::int64_t step = 3; step < 8; ++step) {
        first.advance(step, state);
        second.advance(step, again);
    }
    EXPECT_EQ(state.values, again.values);
    EXPECT_EQ(first.save(), second.save());
    EXPECT_THROW(second.restore(std::vector<double>{0.5, 1.0}), Error);
    EXPECT_THROW(second.restore(std::vector<double>{0.0}), Error);
}

TEST(FieldEvolution, a_restored_evolution_continues_bit_for_bit_while_the_division_changes) {
    Case scene = flock();
    scene.initial.formulas["bead_density"] = {"1 + 0.7 * cos(2*pi*x/20)"};
    scene.control.tolerance = 1e-4;
    Threads threads(1);
    model::FieldEvolution first = evolution_of(scene, threads);
    numerics::Spectra state = initial_spectra(scene.initial, scene.model, first.linear(), 1, threads);
    first.start(state);
    // A restart at every step: none of them depends on what an earlier step left in memory.
    int changes = 0;
    for (std::int64_t step = 0; step < 60; ++step) {
        model::FieldEvolution second = evolution_of(scene, threads);
        second.restore(first.save());
        numerics::Spectra again = state;
        const int division = first.stepper().division();
        first.advance(step, state);
        second.advance(step, again);
        ASSERT_EQ(state.values, again.values) << step;
        ASSERT_EQ(first.save(), second.save()) << step;
        if (first.stepper().division() != division) ++changes;
    }
    EXPECT_GT(changes, 2);
    EXPECT_GT(first.reference_changes(), 0);
}

}  // namespace
}  // namespace drover::physics::field_evolution_tests
