// tests/run/field_evolution.cpp: the step and the reference density that follow a run.
#include "drover/run/field_evolution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drover/numerics/transform.hpp"
#include "drover/physics/initial_state.hpp"

namespace drover::run {
namespace {

/// Beads with inertia and rods that drag them, without noise.
io::Scene flock() {
    io::Scene scene;
    scene.model = {.fields = {.bead_density = true, .rod_density = false, .bead_velocity = "dynamic"},
                   .uniform = {.bead_density = 1.0},
                   .drag = {.coefficient = 4.0},
                   .driving = {.strength = 4.0},
                   .stiffness = {.beads = 2.0},
                   .relaxation = {.rate = 0.5, .saturation = 2.0},
                   .elasticity = {.stiffness = 1.0},
                   .weathercock = {.strength = 1.5},
                   .advection = {.strength = 0.5}};
    scene.grid = {.nx = 32, .ny = 32, .lx = 20.0, .ly = 20.0};
    scene.time = {.dt = 0.5, .end = 4.0, .stepper = "etdrk2"};
    scene.initial = {.kind = "formula",
                     .bead_density = "1 + 0.2 * cos(2*pi*x/20)",
                     .polar_order_x = "0.4 + 0.3 * sin(2*pi*y/20)",
                     .polar_order_y = "0.3 * cos(2*pi*(x + y)/20)"};
    return scene;
}

struct Evolved {
    numerics::Spectra state;
    StepCount count;
    std::vector<double> saved;
};

Evolved evolve(const io::Scene& scene) {
    Threads threads(1);
    FieldEvolution evolution(scene, threads);
    numerics::Spectra state = physics::initial_spectra(scene.initial, scene.model, evolution.system(), 1, threads);
    evolution.start(state);
    const auto steps = static_cast<std::int64_t>(std::lround(scene.time.end / scene.time.dt));
    for (std::int64_t step = 0; step < steps; ++step) evolution.advance(step, state);
    return {std::move(state), evolution.count(), evolution.save()};
}

Evolved reference_of(io::Scene scene) {
    scene.time.stepper = "etdrk4";
    scene.time.dt /= 64.0;
    scene.time.tolerance = 0.0;
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

TEST(AdaptiveStep, brings_the_error_down_with_the_tolerance_at_the_order_of_its_pair) {
    for (const auto& [method, order] : {std::pair{"etdrk2", 2}, {"etdrk4", 4}}) {
        io::Scene scene = flock();
        scene.time.stepper = method;
        const Evolved exact = reference_of(scene);
        std::vector<double> errors;
        std::vector<std::int64_t> steps;
        for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
            scene.time.tolerance = tolerance;
            const Evolved run = evolve(scene);
            errors.push_back(distance(run.state, exact.state));
            steps.push_back(run.count.accepted);
            // Some 4 s of steps, each with an error of at most the tolerance, the slowest mode not growing: 100 of them and more.
            EXPECT_LT(errors.back(), 100.0 * tolerance) << method << ", tolerance " << tolerance;
        }
        EXPECT_LT(errors[1], errors[0]) << method;
        EXPECT_LT(errors[2], errors[1]) << method;
        // The error of the pair falls as dt^order: a hundredth of it takes 100^(1/order) times the steps, within two rungs.
        const double expected = std::pow(100.0, 1.0 / order),
                     found = static_cast<double>(steps[2]) / static_cast<double>(steps[1]);
        EXPECT_NEAR(std::log(found), std::log(expected), std::log(2.0))
            << method << ": " << steps[1] << ", " << steps[2];
    }
}

TEST(AdaptiveStep, is_cut_for_a_fast_start_and_grows_again_when_the_run_is_slow) {
    io::Scene scene = flock();
    scene.time.tolerance = 1e-4;
    scene.time.end = 200.0;
    const Evolved run = evolve(scene);
    EXPECT_GT(run.count.accepted, 120) << "the start asked for steps of less than dt";
    EXPECT_GT(run.count.refused, 0);
    EXPECT_EQ(run.count.division, 1) << "the flock is uniform at the end";
}

TEST(AdaptiveStep, of_a_run_that_blows_up_ends_with_a_sentence) {
    io::Scene scene = flock();
    scene.model.relaxation.saturation = 0.0;
    scene.model.relaxation.rate = -3.0;
    scene.time.tolerance = 1e-4;
    scene.time.end = 4000.0;
    try {
        evolve(scene);
        ADD_FAILURE() << "a field that grows for ever came to its end";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::run) << error.what();
    }
}

TEST(ReferenceDensity, follows_beads_that_thin_out_below_half_of_it) {
    io::Scene scene = flock();
    scene.initial.bead_density = "1 + 0.75 * cos(2*pi*x/20)";
    scene.model.stiffness.beads = 0.3;
    scene.model.drag.coefficient = 4000.0;  // Gamma dt/rho = 400 at the reference, 1600 where the beads are thin
    scene.model.driving.strength = 4000.0;
    scene.initial.bead_velocity_x = scene.initial.polar_order_x;  // in balance with the drag: no layer at the start
    scene.initial.bead_velocity_y = scene.initial.polar_order_y;
    scene.time.dt = 0.1;
    scene.time.end = 2.0;
    const Evolved run = evolve(scene), fine = reference_of(scene);
    EXPECT_GT(run.count.references, 0);
    EXPECT_LT(run.saved[0], 0.0) << "the reference lies below the mean";
    EXPECT_LT(distance(run.state, fine.state), 5e-3);  // dt^2 of rates up to one, a few times
}

TEST(ReferenceDensity, follows_a_heap_of_slaved_beads_up) {
    io::Scene scene = flock();
    scene.model = {.fields = {.bead_density = true, .rod_density = false, .bead_velocity = "slaved"},
                   .uniform = {.bead_density = 0.1},
                   .drag = {.coefficient = 1.0},
                   .stiffness = {.beads = 1.0}};
    scene.grid = {.nx = 64, .ny = 64, .lx = 16.0, .ly = 16.0};
    scene.time = {.dt = 0.02, .end = 2.0};
    scene.initial = {.kind = "formula", .bead_density = "exp(-((x - 8)^2 + (y - 8)^2)/4)"};
    const Evolved run = evolve(scene), fine = reference_of(scene);
    EXPECT_GT(run.saved[0], 0.0)
        << "rho E/Gamma of the peak is ten times that of the mean: the reference lies above it";
    EXPECT_LT(distance(run.state, fine.state), 1e-3);  // dt^2 of rates of order one
}

TEST(FieldEvolution, keeps_the_total_of_the_beads_through_refused_steps_and_changes_of_the_reference) {
    io::Scene scene = flock();
    scene.initial.bead_density = "1 + 0.7 * cos(2*pi*x/20)";
    scene.time.tolerance = 1e-4;
    scene.time.end = 40.0;
    const Evolved run = evolve(scene);
    EXPECT_GT(run.count.refused, 0);
    EXPECT_GT(run.count.references, 0);
    // The mode q = 0 has no rate: what it started with, 1 to the rounding of the transform of the start.
    EXPECT_NEAR(run.state[0][0].real(), 1.0, 1e-15);
}

TEST(FieldEvolution, goes_on_from_what_it_saved_as_if_it_had_not_stopped) {
    io::Scene scene = flock();
    scene.initial.bead_density = "1 + 0.7 * cos(2*pi*x/20)";
    scene.time.tolerance = 1e-5;
    Threads threads(1);
    FieldEvolution first(scene, threads);
    numerics::Spectra state = physics::initial_spectra(scene.initial, scene.model, first.system(), 1, threads);
    first.start(state);
    for (std::int64_t step = 0; step < 3; ++step) first.advance(step, state);
    FieldEvolution second(scene, threads);
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

}  // namespace
}  // namespace drover::run
