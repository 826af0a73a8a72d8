// tests/numerics/watched_stepper.cpp: the error of the steps of an oscillation, whose exact solution is known.
#include "drover/numerics/watched_stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

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

}  // namespace
}  // namespace drover::numerics::watched_stepper_tests
