// tests/numerics/watched_stepper.cpp: the error of the steps of an oscillation, whose exact solution is known.
#include "numerics/steppers/watched_stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>

#include "numerics/steppers/effort.hpp"

namespace drover::numerics::watched_stepper_tests {
namespace {
/// A' = A - (1 + i c) |A|^2 A of a uniform A = X + i Y: exp(-i c t) is exact.  Errors of |A| decay and change the
/// phase.
System oscillator(const Grid& grid, double c) {
    return {.grid = grid,
            .layout = {.fields = {{.spin = 0}, {.spin = 0}}},
            .linear =
                [](double) {
                    IsotropicBlocks blocks{.even = Block(2), .odd = Block(0)};
                    blocks.even(0, 0) = blocks.even(1, 1) = 1.0;
                    return blocks;
                },
            .nonlinear =
                [c](double, const Spectra& state, Spectra& rate) {
                    std::fill(rate.values.begin(), rate.values.end(), Complex(0.0));
                    const double x = state[0][0].real(), y = state[1][0].real(), square = x * x + y * y;
                    rate[0][0] = -square * (x - c * y);
                    rate[1][0] = -square * (y + c * x);
                },
            .noise = {},
            .degree = 3};
}

TEST(WatchedStepper, adds_up_errors_that_turn_with_an_oscillation) {
    const Grid grid{.nx = 4, .ny = 4, .lx = 4.0, .ly = 4.0};
    for (const double c : {-1.0, 0.5, 3.0}) {
        const double period = 2.0 * M_PI / std::abs(c), dt = period / 120.0;
        Threads threads(1);
        const ErrorEquations errors{.fields = {{.first = 0, .name = "X"}, {.first = 1, .name = "Y"}},
                                    .on_grid = [c](const Grid& on, int, Threads&) { return oscillator(on, c); },
                                    .degree = 3};
        WatchedStepper stepper({.method = "etdrk2", .dt = dt}, oscillator(grid, c), 1, threads, errors);
        Spectra state(grid, 2);
        state[0][0] = 1.0;
        for (std::int64_t step = 0; step < 120 * 20; ++step) {
            stepper.advance(step, state);
            stepper.watch(step, state);
            const auto steps = step + 1;
            if (steps != 120 && steps != 120 * 5 && steps != 120 * 20) continue;  // whole periods
            // The larger of both fields, relative to the fluctuation of a sine.
            const double x = state[0][0].real() - 1.0, y = state[1][0].real();
            const double wrong = std::max(std::abs(x), std::abs(y)) * M_SQRT2, told = stepper.step_error().error;
            // Between two checks the errors turn by 50 degrees.  In the first period at c = 3 errors of phase and size
            // cancel: they are 6 times as large as their sum.
            EXPECT_GT(told, 0.5 * wrong) << "c = " << c << ", " << steps << " steps";
            EXPECT_LT(told, 2.5 * wrong) << "c = " << c << ", " << steps << " steps";
        }
    }
}

/// A relaxation that is explicit and fast for its step, driven by noise.
System relaxing(const Grid& grid, double rate) {
    const auto diagonal = [](double value) {
        IsotropicBlocks blocks{.even = Block(1), .odd = Block(0)};
        blocks.even(0, 0) = value;
        return blocks;
    };
    return {.grid = grid,
            .layout = {.fields = {{.spin = 0}}},
            .linear = [=](double) { return diagonal(-1.0); },
            .nonlinear =
                [=](double, const Spectra& state, Spectra& out) {
                    for (std::size_t k = 0; k < out.values.size(); ++k) out.values[k] = -rate * state.values[k];
                },
            .noise = [=](double) { return diagonal(1.0); },
            .degree = 1};
}

/// What an estimate takes of a run of so many steps, in steps of it: right-hand sides, weighed by their points.
struct Taken {
    double steps = 0.0;
    double allowed = 0.0;  // with what may be owed
    StepError::Relative told;
};

Taken taken_by(double part, const std::function<System(const Grid&)>& system_on, const Grid& grid, double dt,
               std::int64_t steps) {
    Threads threads(1);
    double evaluated = 0.0;
    const auto counted = [&](const Grid& on) {
        System system = system_on(on);
        system.nonlinear = [&evaluated, rate = system.nonlinear,
                            weight = weighed_points(on) / weighed_points(grid)](double t, const Spectra& state,
                                                                                Spectra& out) {
            evaluated += weight;
            rate(t, state, out);
        };
        return system;
    };
    const System run = counted(grid);
    const int count = components(run.layout);
    const bool noisy = static_cast<bool>(run.noise);
    const StepWork work =
        step_work(grid, {.components = count, .noisy = noisy ? count : 0, .inverse = count, .forward = count});
    ErrorEquations errors{.on_grid = [&](const Grid& on, int, Threads&) { return counted(on); },
                          .degree = run.degree,
                          .noisy = noisy,
                          .shortest = 100.0};  // all points: the error costs as much as the run
    for (int c = 0; c < count; ++c) errors.fields.push_back({.first = c, .name = "X"});
    WatchedStepper stepper({.method = "etdrk2", .dt = dt, .effort = part, .work = work}, run, 1, threads, errors);
    Spectra state(grid, count);
    state[0][0] = 1.0;
    for (std::int64_t step = 0; step < steps; ++step) {
        stepper.advance(step, state);
        stepper.watch(step, state);
    }
    constexpr double per_step = 2.0;
    const double work_a_step = per_step * work.rate + work.noise;
    return {.steps = evaluated / per_step - static_cast<double>(steps),
            .allowed = (1.2 * Effort{.part = part}.allowed(stepper.work_done()) + 2.0 * owed_work()) / work_a_step,
            .told = stepper.step_error()};
}

constexpr double oscillation = 3.0, oscillation_dt = 2.0 * M_PI / oscillation / 120.0;

TEST(WatchedStepper, takes_no_more_than_its_effort_and_knows_no_error_where_that_does_not_suffice) {
    const auto turning = [](const Grid& grid) { return oscillator(grid, oscillation); };
    const Grid grid{.nx = 64, .ny = 64, .lx = 64.0, .ly = 64.0}, large{.nx = 256, .ny = 256, .lx = 256.0, .ly = 256.0};
    const Taken all = taken_by(INFINITY, turning, grid, oscillation_dt, 4000),
                some = taken_by(0.03, turning, grid, oscillation_dt, 4000),
                few = taken_by(1e-4, turning, large, oscillation_dt, 60);
    EXPECT_GT(all.steps, some.allowed);
    EXPECT_LT(some.steps, some.allowed);
    EXPECT_FALSE(std::isnan(all.told.error));
    // Three steps: the first local error, which every run has.
    EXPECT_LT(few.steps, few.allowed + 3.0);
    EXPECT_TRUE(std::isnan(few.told.error));
}

TEST(WatchedStepper, holds_the_error_under_noise_where_it_would_take_more_than_its_effort) {
    const auto system = [](const Grid& grid) { return relaxing(grid, 5.0); };
    const Grid grid{.nx = 64, .ny = 64, .lx = 64.0, .ly = 64.0};
    const Taken all = taken_by(INFINITY, system, grid, 0.1, 3000), some = taken_by(0.02, system, grid, 0.1, 3000);
    EXPECT_GT(all.steps, some.allowed);
    EXPECT_LT(some.steps, some.allowed);
    // Both are sums over thousands of modes of errors that last a few steps; in a hurry its steps are twice as long.
    EXPECT_NEAR(some.told.error, all.told.error, 0.5 * all.told.error);
}

/// z' = -s z drives a damped oscillation: u' = (-g - i w) u + z of u = x + i y.
System driven_oscillation(const Grid& grid, double s, double g, double w) {
    return {.grid = grid,
            .layout = {.fields = {{.spin = 0}, {.spin = 0}, {.spin = 0}}},
            .linear = [](double) { return IsotropicBlocks{.even = Block(3), .odd = Block(0)}; },
            .nonlinear =
                [=](double, const Spectra& state, Spectra& rate) {
                    std::fill(rate.values.begin(), rate.values.end(), Complex(0.0));
                    const Complex u = state[0][0].real() + Complex(0.0, 1.0) * state[1][0].real(), z = state[2][0],
                                  change = Complex(-g, -w) * u + z;
                    rate[0][0] = change.real();
                    rate[1][0] = change.imag();
                    rate[2][0] = -s * z;
                },
            .noise = {},
            .degree = 1};
}

TEST(WatchedStepper, does_not_let_errors_grow_that_oscillate_in_slow_fields) {
    const Grid grid{.nx = 64, .ny = 64, .lx = 64.0, .ly = 64.0};
    constexpr double s = 5e-4, g = 0.02, w = 0.2;
    Threads threads(1);
    ErrorEquations errors{.on_grid = [&](const Grid& on, int, Threads&) { return driven_oscillation(on, s, g, w); },
                          .degree = 1,
                          .shortest = 100.0};
    for (int c = 0; c < 3; ++c) errors.fields.push_back({.first = c, .name = "u"});
    const StepWork work = step_work(grid, {.components = 3, .inverse = 3, .forward = 3});
    WatchedStepper stepper({.method = "etdrk2", .dt = 1.0, .effort = 1.0, .work = work},
                           driven_oscillation(grid, s, g, w), 1, threads, errors);
    const Complex follows = 1.0 / Complex(g - s, w);  // u/z where no oscillation is left
    Spectra state(grid, 3);
    state[0][0] = follows.real();
    state[1][0] = follows.imag();
    state[2][0] = 1.0;
    constexpr std::int64_t steps = 3000;
    double squares = 0.0, sum = 0.0;
    for (std::int64_t step = 0; step < steps; ++step) {
        const double x = state[0][0].real();
        squares += x * x / steps;
        sum += x / steps;
        stepper.advance(step, state);
        stepper.watch(step, state);
    }
    const double exact = std::exp(-s * steps) * follows.real();
    const double wrong = std::abs(state[0][0].real() - exact) / std::sqrt(squares - sum * sum);
    EXPECT_LT(stepper.step_error().error, 4.0 * wrong);
    EXPECT_GT(stepper.step_error().error, 0.25 * wrong);
}

TEST(Effort, is_a_part_of_the_time_of_a_run_and_twice_that_of_a_short_one) {
    const Effort effort{.part = 0.05};
    constexpr double short_run = 9e10;  // instructions in 10 s
    const double start = effort.allowed(0.0) / 0.1;
    double all_before = start;
    for (double work = 0.0, before = 0.0; work < 1e13; work = 1.5 * work + 1e8) {
        const double all = start + work, allowed = effort.allowed(work);
        EXPECT_LE(allowed, (all < short_run ? 0.1 : 0.05) * all * (1.0 + 1e-12));
        EXPECT_GE(allowed, 0.05 * all * (1.0 - 1e-12));
        EXPECT_GE(allowed - before, 0.02 * (all - all_before));  // a long wait would leave errors unknown
        all_before = all;
        before = allowed;
    }
}

}  // namespace
}  // namespace drover::numerics::watched_stepper_tests
