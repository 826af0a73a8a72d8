// tests/physics/relaxation.cpp: uniform states: Landau's growth of the order, and the angle between order and beads.
#include <gtest/gtest.h>

#include <cmath>

#include "evolution.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::relaxation_tests {
namespace {

constexpr numerics::Grid tiny{4, 4, 1.0, 1.0};

FieldFunction constant(double value) {
    return [value](double, double) { return value; };
}

/// The only cell there is to look at: fields of a uniform state.
std::vector<double> means(const numerics::Spectra& state) {
    std::vector<double> values;
    for (int c = 0; c < state.count(); ++c) values.push_back(state[c][0].real());
    return values;
}

/// abar = a - lambda alpha/Gamma = 0.4 - 0.75 * 1.6/1.5 = -0.4: order grows because driven beads turn rods.
Model slaved_flock() {
    return {.fields = {.bead_density = false, .rod_density = false, .bead_velocity = "slaved"},
            .drag = {.coefficient = 1.5},
            .driving = {.strength = 1.6},
            .relaxation = {.rate = 0.4, .saturation = 0.8},
            .weathercock = {.strength = 0.75}};
}

TEST(UniformRelaxation, order_follows_landau_from_below_and_from_above_saturation_without_turning) {
    const double abar = -0.4, saturated = 0.4 / 0.8, dt = 0.002;
    Evolution run(slaved_flock(), tiny);
    for (const double start : {0.01, 0.3, 2.0}) {
        numerics::Spectra state = run.spectra({constant(0.6 * start), constant(-0.8 * start)});
        numerics::Stepper by = run.stepper("etdrk4", dt);
        for (int i = 0; i < 10000; ++i) {
            by.step(i * dt, static_cast<std::uint64_t>(i), state);
            const double t = (i + 1) * dt;
            const double square = saturated / (1.0 + (saturated / (start * start) - 1.0) * std::exp(2.0 * abar * t));
            const std::vector<double> p = means(state);
            // A step of the fourth-order method errs by some (rate dt)^5/120; the fastest rate, 2 b p^2 = 6.4 at the
            // start of p = 2, lasts some 1/(rate dt) steps: (0.0128)^4/120 = 2e-10.
            ASSERT_NEAR(p[0] * p[0] + p[1] * p[1], square, 1e-9) << "p(0) = " << start << ", t = " << t;
            // No term turns p: all of them are along it.
            ASSERT_NEAR(p[0] * 0.8 + p[1] * 0.6, 0.0, 1e-14);
        }
    }
}

TEST(UniformRelaxation, order_of_a_slaved_flock_decays_where_the_beads_do_not_turn_rods_enough) {
    Model model = slaved_flock();
    model.weathercock.strength = 0.1875;  // abar = 0.4 - 0.2 = 0.2
    Evolution run(model, tiny);
    numerics::Spectra state = run.spectra({constant(0.3), constant(0.4)});
    run.advance(state, "etdrk4", 0.02, 500);
    // p^2 = p(0)^2 e^(-2 abar t)/[1 + (b/abar) p(0)^2 (1 - e^(-2 abar t))], t = 10.
    const double decay = std::exp(-4.0), square = 0.25 * decay / (1.0 + 4.0 * 0.25 * (1.0 - decay));
    const std::vector<double> p = means(state);
    EXPECT_NEAR((p[0] * p[0] + p[1] * p[1]) / square, 1.0, 1e-9);  // (rate dt)^4/120 as above, the rate 0.4
}

TEST(UniformRelaxation, beads_and_order_come_to_lie_along_each_other_at_the_rate_of_relaxation_and_drag_together) {
    Model model = full_model();
    model.force = {};
    model.orienting_field = {};
    const double rho = model.uniform.bead_density, sigma = model.uniform.rod_density;
    const double a = 0.4 - 0.5 * sigma + 0.2 * rho * rho, b = 0.8 + 0.3 * rho, gamma = 1.1 + 0.3 * rho + 0.2 * sigma,
                 inertia = 1.4 * rho;
    Evolution run(model, tiny);
    numerics::Spectra state =
        run.spectra({constant(rho), constant(sigma), constant(-0.5), constant(0.9), constant(1.1), constant(0.2)});
    const auto cross = [&] {
        const std::vector<double> f = means(state);
        return f[4] * f[3] - f[5] * f[2];
    };
    const auto rate = [&] {
        const std::vector<double> f = means(state);
        return a + b * (f[4] * f[4] + f[5] * f[5]) + gamma / inertia;
    };
    const double dt = 0.0025, start = cross();
    double integral = 0.0;
    numerics::Stepper by = run.stepper("etdrk4", dt);
    for (int i = 0; i < 1200; i += 2) {
        const double first = rate();
        by.step(i * dt, static_cast<std::uint64_t>(i), state);
        const double middle = rate();
        by.step((i + 1) * dt, static_cast<std::uint64_t>(i) + 1, state);
        integral += dt / 3.0 * (first + 4.0 * middle + rate());
        // Method and Simpson's rule are both right to (rate dt)^4/120, the rates a + b p^2 and Gamma/(m rho) being
        // some 3 at first, 2 b p^2 as much again: (6 * 0.0025)^4/120 = 4e-10.
        ASSERT_NEAR(cross() / (start * std::exp(-integral)), 1.0, 1e-9) << "t = " << (i + 2) * dt;
    }
    EXPECT_LT(cross() / start, 0.03) << "so much of the angle is gone that its decay has been seen";
    EXPECT_EQ(means(state)[0], rho);
    EXPECT_EQ(means(state)[1], sigma);
}

}  // namespace
}  // namespace drover::physics::relaxation_tests
