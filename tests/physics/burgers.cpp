// tests/physics/burgers.cpp: order that only carries and smooths itself: two-dimensional Burgers, by Cole and Hopf.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "evolution.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::burgers_tests {
namespace {

constexpr double carried = 1.7, stiffness = 0.06, splay = 0.04;  // w, K3, K1
constexpr double side = 2.0 * std::numbers::pi;

Model burgers() {
    return {.fields = {.bead_density = false, .rod_density = false, .bead_velocity = "absent"},
            .relaxation = {.rate = 0.0},
            .elasticity = {.stiffness = stiffness, .splay = splay},
            .advection = {.strength = carried}};
}

/// psi = 3 + sum of waves that decay as the heat equation has it; a gradient feels K1 + K3.
struct Heat {
    struct Wave {
        double height, kx, ky, phase;
    };
    static constexpr double diffusion = stiffness + splay;
    static constexpr std::array<Wave, 4> waves{
        {{1.0, 1.0, 0.0, 0.0}, {0.6, 1.0, 2.0, 0.4}, {0.5, -1.0, 1.0, 1.1}, {0.3, 0.0, 2.0, -0.7}}};

    /// p = -[2 (K1 + K3)/w] grad ln psi, along axis 0 or 1.
    static double order(double x, double y, double t, int axis) {
        double psi = 3.0, slope = 0.0;
        for (const Wave& wave : waves) {
            const double height = wave.height * std::exp(-diffusion * (wave.kx * wave.kx + wave.ky * wave.ky) * t);
            const double turn = wave.kx * x + wave.ky * y + wave.phase;
            psi += height * std::cos(turn);
            slope -= height * (axis == 0 ? wave.kx : wave.ky) * std::sin(turn);
        }
        return -2.0 * diffusion / carried * slope / psi;
    }
    static std::vector<FieldFunction> at(double t) {
        return {[t](double x, double y) { return order(x, y, t, 0); },
                [t](double x, double y) { return order(x, y, t, 1); }};
    }
};

/// The largest error of p at t = 2, over the largest p there is at first.
double error(int n, double dt) {
    Evolution run(burgers(), {n, n, side, side});
    numerics::Spectra state = run.spectra(Heat::at(0.0));
    run.advance(state, "etdrk4", dt, static_cast<int>(std::lround(2.0 / dt)));
    const numerics::Fields at_first = run.sampled(Heat::at(0.0));
    return largest_difference(run.fields(state), run.sampled(Heat::at(2.0))) /
           largest_difference(at_first, numerics::Fields(run.grid, 2));
}

TEST(Burgers, curl_free_order_in_two_dimensions_follows_cole_and_hopf_with_spectral_accuracy) {
    const double coarse = error(16, 0.01), middle = error(32, 0.01), fine = error(64, 0.01);
    // Order is analytic as far from the real plane as psi has no zero: its series falls exponentially, and twice the
    // modes square the error.
    EXPECT_GT(coarse / middle, 30.0) << coarse << ", " << middle;
    EXPECT_GT(middle / fine, 10.0 * coarse / middle) << coarse << ", " << middle << ", " << fine;
    // (1e-6)^2 of space, and of time 1e-6 at dt = 0.25 (below) to the fourth power of the step: 3e-12.
    EXPECT_LT(fine, 1e-10);
}

TEST(Burgers, error_of_the_step_falls_at_the_order_of_the_method) {
    const double large = error(96, 0.5), small = error(96, 0.25);
    EXPECT_GT(std::log2(large / small), 3.7) << large << ", " << small;
}

}  // namespace
}  // namespace drover::physics::burgers_tests
