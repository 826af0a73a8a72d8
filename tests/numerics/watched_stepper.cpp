// tests/numerics/watched_stepper.cpp: the error of the steps of an oscillation, whose exact solution is known.
#include "drover/numerics/watched_stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "drover/numerics/effort.hpp"

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

/// What an estimate takes of a run of so many steps, in steps of it: right-hand sides, weighed by their points.
struct Taken {
    double steps = 0.0;
    double allowed = 0.0;  // with what may be owed
    StepError::Relative told;
};

Taken taken_by(double part, const Grid& grid, std::int64_t steps) {
    constexpr double c = 3.0, dt = 2.0 * M_PI / c / 120.0;
    Threads threads(1);
    double evaluated = 0.0;
    const auto counted = [&](const Grid& on) {
        System system = oscillator(on, c);
        system.nonlinear = [&evaluated, rate = system.nonlinear,
                            weight = weighed_points(on) / weighed_points(grid)](double t, const Spectra& state,
                                                                                Spectra& out) {
            evaluated += weight;
            rate(t, state, out);
        };
        return system;
    };
    const StepWork work = step_work(grid, {.components = 2, .inverse = 2, .forward = 2});
    const ErrorEquations errors{.fields = {{.first = 0, .name = "X"}, {.first = 1, .name = "Y"}},
                                .on_grid = [&](const Grid& on, int, Threads&) { return counted(on); },
                                .degree = 3,
                                .shortest = 100.0};  // all points: the error costs as much as the run
    WatchedStepper stepper({.method = "etdrk2", .dt = dt, .effort = part, .work = work}, counted(grid), 1, threads,
                           errors);
    Spectra state(grid, 2);
    state[0][0] = 1.0;
    for (std::int64_t step = 0; step < steps; ++step) {
        stepper.advance(step, state);
        stepper.watch(step, state);
    }
    constexpr double per_step = 2.0;
    const Effort effort{.part = part};
    const double work_a_step = per_step * work.rate;
    return {.steps = evaluated / per_step - static_cast<double>(steps),
            .allowed =
                (1.2 * effort.allowed(static_cast<double>(steps) * work_a_step) + 2.0 * owed_work()) / work_a_step,
            .told = stepper.step_error()};
}

TEST(WatchedStepper, takes_no_more_than_its_effort_and_knows_no_error_where_that_does_not_suffice) {
    const Grid grid{.nx = 64, .ny = 64, .lx = 64.0, .ly = 64.0}, large{.nx = 256, .ny = 256, .lx = 256.0, .ly = 256.0};
    const Taken all = taken_by(INFINITY, grid, 4000), some = taken_by(0.03, grid, 4000),
                few = taken_by(1e-4, large, 60);
    EXPECT_GT(all.steps, some.allowed);
    EXPECT_LT(some.steps, some.allowed);
    EXPECT_FALSE(std::isnan(all.told.error));
    // Three steps: the first local error, which every run has.
    EXPECT_LT(few.steps, few.allowed + 3.0);
    EXPECT_TRUE(std::isnan(few.told.error));
}

TEST(Effort, is_a_part_of_the_time_of_a_run_and_twice_that_of_a_short_one) {
    const Effort effort{.part = 0.05};
    constexpr double short_run = 9e10;  // instructions in 10 s
    const double start = effort.allowed(0.0) / 0.1;
    for (double work = 0.0, before = 0.0; work < 1e13; work = 1.5 * work + 1e8) {
        const double all = start + work, allowed = effort.allowed(work);
        EXPECT_LE(allowed, (all < short_run ? 0.1 : 0.05) * all * (1.0 + 1e-12));
        EXPECT_GE(allowed, 0.05 * all * (1.0 - 1e-12));
        EXPECT_GE(allowed, before);
        before = allowed;
    }
}

}  // namespace
}  // namespace drover::numerics::watched_stepper_tests
