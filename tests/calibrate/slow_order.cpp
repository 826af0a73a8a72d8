// tests/calibrate/slow_order.cpp: effective coefficients of rods and beads against closed forms.
#include "calibrate/slow_order.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "physics/flock_model.hpp"

namespace drover::calibrate::slow_order_tests {
namespace {

using physics::effective_coefficients;
using physics::EffectiveCoefficients;
using physics::Equations;
using physics::flock_model;
using physics::isotropic_letters;
using physics::Letters;
using physics::Model;

TEST(WhyNoOrder, is_told_by_the_coefficients) {
    const auto why = [](const Model& model) { return why_no_order(Equations(model)); };
    EXPECT_NE(why(flock_model(isotropic_letters())).find("is not below 0"), std::string::npos);
    EXPECT_EQ(why(flock_model({})), "");  // these have an order
    EXPECT_NE(why(flock_model({.b = 0.0})).find("saturation is 0: order grows without bound"), std::string::npos);
    EXPECT_NE(why(flock_model({.gamma = 0.0})).find("drag.coefficient is 0"), std::string::npos);
    Model pushed = flock_model({.gamma = 0.0, .alpha = 0.0});
    pushed.force = {.kind = "uniform", .x = 1.0};
    EXPECT_NE(why(pushed).find("accelerate without limit"), std::string::npos);
    Model cubic = flock_model({});
    cubic.driving.cubic = 3.0;  // more than b Gamma/lambda: the flow grows faster with the order than b stops it
    EXPECT_NE(why(cubic).find("alpha_3/Gamma"), std::string::npos);
}

TEST(EffectiveCoefficients, outside_a_table_are_rejected_with_its_range) {
    Model model = flock_model({});
    model.table = {.bead_density = {1.0, 1.5},
                   .rod_density = {0.5, 1.0},
                   .columns = {{"relaxation.rate", {{0.1, 0.2, 0.3, 0.4}, {}}}}};
    const Equations e(model);
    EXPECT_NO_THROW(effective_coefficients(e, 1.2, 0.9));
    try {
        effective_coefficients(e, 1.2, 1.1);
        FAIL();
    } catch (const Error& error) {
        EXPECT_STREQ(
            error.what(),
            "relaxation.rate is not defined at the densities 1.2 (beads) and 1.1 (rods), outside its table of bead "
            "density 1 to 1.5, rod density 0.5 to 1; use densities inside the table, or set table.outside = \"hold\"");
    }
}

TEST(EffectiveCoefficients, are_the_combinations_of_the_closed_forms) {
    const Letters l = isotropic_letters();
    const EffectiveCoefficients found = effective_coefficients(Equations(flock_model(l)), l.rho, 0.9);
    EXPECT_NEAR(found.inertia, l.chi(), 1e-15);
    EXPECT_NEAR(found.relaxation, l.abar(), 1e-15);
    EXPECT_NEAR(found.pressure_beads, l.abar_beads(), 1e-15);
    EXPECT_NEAR(found.pressure_rods, l.bbar(), 1e-15);
    EXPECT_NEAR(found.sound_stiffness, l.c0(), 1e-15);
    const double gain = l.lambda * l.alpha / (l.gamma * l.gamma);
    EXPECT_NEAR(found.stiffness_across, l.k3 + gain * l.eta, 1e-15);
    EXPECT_NEAR(found.stiffness_along, l.k3 + l.k1 + gain * (l.eta + l.zeta), 1e-15);
    // (Gamma + eta q^2)(a + K3 q^2) = lambda alpha at q^2 = -1/xi^2.
    const double square = -1.0 / (found.correlation_length * found.correlation_length);
    EXPECT_NEAR((l.gamma + l.eta * square) * (l.a + l.k3 * square), l.lambda * l.alpha, 1e-14);
    EXPECT_TRUE(std::isnan(found.neutral_wavenumber));
}

TEST(EffectiveCoefficients, without_coupling_to_the_beads_need_no_drag) {
    const Letters l{.gamma = 0.0, .alpha = 0.0};
    const EffectiveCoefficients found = effective_coefficients(Equations(flock_model(l)), l.rho, 0.9);
    EXPECT_EQ(found.relaxation, l.a);
    EXPECT_EQ(found.inertia, 1.0);
    EXPECT_NEAR(found.correlation_length, std::sqrt(l.k3 / l.a), 1e-15);
}

TEST(EffectiveCoefficients, have_the_slopes_of_the_effective_relaxation) {
    Model model = flock_model({});
    model.relaxation.rate_terms = {"-0.1 sigma", "-0.05 rho"};
    model.driving.strength_terms = {"0.1 rho sigma"};
    model.drag.coefficient_terms = {"0.2 rho^2"};
    model.weathercock.strength_terms = {"0.15 sigma"};
    const Equations e(model);
    const auto abar = [&](double rho, double sigma) { return effective_coefficients(e, rho, sigma).relaxation; };
    const EffectiveCoefficients found = effective_coefficients(e, 1.3, 0.9);
    constexpr double h = 1e-4;  // error h^2 = 1e-8 times third derivatives of order one
    EXPECT_NEAR(found.relaxation_by_beads, (abar(1.3 + h, 0.9) - abar(1.3 - h, 0.9)) / (2.0 * h), 1e-7);
    EXPECT_NEAR(found.relaxation_by_rods, (abar(1.3, 0.9 + h) - abar(1.3, 0.9 - h)) / (2.0 * h), 1e-7);
}

}  // namespace
}  // namespace drover::calibrate::slow_order_tests
