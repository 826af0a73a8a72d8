// tests/physics/uniform_states.cpp: stationary states do not change under the solver, and all of them are found.
#include "drover/physics/uniform_states.hpp"

#include <gtest/gtest.h>

#include "flock_model.hpp"
#include "full_model.hpp"

namespace drover::physics::uniform_states_tests {
namespace {

constexpr numerics::Grid grid{8, 8, 5.0, 5.0};

/// The largest rate of the solver's own equations in a uniform state, whatever the form.
double largest_rate(const Equations& e, const UniformPoint& point) {
    Threads threads(1);
    WholeRate rate(e, grid, {.bead_density = point.bead_density, .rod_density = point.rod_density}, threads);
    numerics::Spectra state(grid, numerics::components(layout(e.form)));
    const auto put = [&](int component, double value) {
        if (component >= 0) state[component][0] = value;
    };
    put(e.form.bead_density, point.bead_density);
    put(e.form.rod_density, point.rod_density);
    if (e.form.bead_velocity >= 0) {
        put(e.form.bead_velocity, point.velocity.x());
        put(e.form.bead_velocity + 1, point.velocity.y());
    }
    put(e.form.polar_order, point.order.x());
    put(e.form.polar_order + 1, point.order.y());
    const numerics::Spectra rates = rate(0.0, state);
    double largest = 0.0;
    for (const numerics::Complex& value : rates.values) largest = std::max(largest, std::abs(value));
    return largest;
}

TEST(StationaryStates, are_unchanged_by_the_solver_in_every_form) {
    int ordered = 0;
    for (const NamedModel& form : all_forms())
        for (const bool field : {true, false}) {
            Model model = form.model;
            if (!field) {
                model.force.kind = "none";
                model.orienting_field = {};
            }
            model.relaxation.rate -= 1.2;  // past the threshold
            const Equations e(model);
            const StationaryStates found = stationary_states(e);
            EXPECT_GE(found.states.size(), field ? 1u : 2u) << form.name;
            for (const StationaryState& state : found.states) {
                EXPECT_LT(largest_rate(e, state.point), 1e-13)
                    << form.name << ", " << state.name;  // numbers of order one
                ordered += state.point.order.norm() > 0.1;
            }
        }
    EXPECT_GE(ordered, 16);
}

TEST(StationaryStates, in_a_weak_field_are_three_and_in_a_strong_one_one) {
    // p^3 - p = h: three real roots below h = 2/sqrt(27).
    Model model{.uniform = {.rod_density = 1.0}, .relaxation = {.rate = -1.0, .saturation = 1.0}};
    const double limit = 2.0 / std::sqrt(27.0);
    for (const double h : {0.5 * limit, 0.999 * limit, 1.001 * limit, 5.0}) {
        model.orienting_field = {.x = 0.6 * h, .y = 0.8 * h};
        const StationaryStates found = stationary_states(Equations(model));
        ASSERT_EQ(found.states.size(), h < limit ? 3u : 1u) << h;
        EXPECT_EQ(found.states[0].name, "along the field");
        for (const StationaryState& state : found.states) {
            const double p = state.point.order.dot(Eigen::Vector2d(0.6, 0.8));
            EXPECT_NEAR(p * p * p - p, h, 1e-14 * (1.0 + h));
            EXPECT_NEAR(std::abs(p), state.point.order.norm(), 1e-14);
            EXPECT_FALSE(state.free_direction);
        }
    }
}

TEST(StationaryStates, that_do_not_exist_are_explained) {
    const auto why = [](const Model& model) { return stationary_states(Equations(model)).no_order; };
    Letters above = isotropic_letters();
    EXPECT_NE(why(flock_model(above)).find("is not below 0"), std::string::npos);
    EXPECT_NE(why(flock_model({.b = 0.0})).find("saturation is 0: order grows without bound"), std::string::npos);
    Model still = flock_model({.gamma = 0.0});
    EXPECT_NE(why(still).find("drag.coefficient is 0"), std::string::npos);
    EXPECT_EQ(stationary_states(Equations(still)).states.size(), 1u);  // at rest, without order
    Model pushed = flock_model({.gamma = 0.0, .alpha = 0.0});
    pushed.force = {.kind = "uniform", .x = 1.0};
    EXPECT_TRUE(stationary_states(Equations(pushed)).states.empty());
    EXPECT_NE(why(pushed).find("accelerate without limit"), std::string::npos);
    EXPECT_EQ(why(flock_model({})), "");
}

TEST(StationaryStates, of_beads_without_drag_balance_a_force_by_order) {
    // alpha p + f = 0 and lambda v = (a + b p^2) p.
    Model model = flock_model({.gamma = 0.0});
    model.force = {.kind = "uniform", .x = 0.4, .y = -0.1};
    const Equations e(model);
    const StationaryStates found = stationary_states(e);
    ASSERT_EQ(found.states.size(), 1u);
    EXPECT_LT(largest_rate(e, found.states[0].point), 1e-14);
    model.driving.cubic = 0.5;  // (alpha + alpha_3 p^2) p + f = 0 has no closed form here: it is searched for
    const Equations cubic(model);
    const StationaryStates searched = stationary_states(cubic);
    ASSERT_EQ(searched.states.size(), 1u);
    EXPECT_LT(largest_rate(cubic, searched.states[0].point), 1e-12);
}

TEST(StationaryStates, with_cubic_driving_have_the_flow_and_the_order_of_the_closed_form) {
    const Letters l;
    Model model = flock_model(l);
    model.driving.cubic = -0.6;
    const Equations e(model);
    const StationaryStates found = stationary_states(e);
    ASSERT_EQ(found.states.size(), 2u);
    const double order = std::sqrt(-l.abar() / (l.b + l.lambda * 0.6 / l.gamma));
    EXPECT_NEAR(found.states[1].point.order.x(), order, 1e-14);
    EXPECT_NEAR(found.states[1].point.velocity.x(), (l.alpha - 0.6 * order * order) * order / l.gamma, 1e-14);
    EXPECT_LT(largest_rate(e, found.states[1].point), 1e-14);
    model.driving.cubic = 3.0;  // more than b Gamma/lambda: the flow grows faster with the order than b stops it
    EXPECT_NE(stationary_states(Equations(model)).no_order.find("alpha_3/Gamma"), std::string::npos);
}

TEST(StationaryStates, outside_a_table_are_rejected_with_its_range) {
    Model model = flock_model({});
    model.table = {.bead_density = {1.0, 1.5},
                   .rod_density = {0.5, 1.0},
                   .columns = {{"relaxation.rate", {{0.1, 0.2, 0.3, 0.4}, {}}}}};
    const Equations e(model);
    EXPECT_EQ(stationary_states(e, 1.2, 0.9).states.size(), 2u);
    try {
        stationary_states(e, 1.2, 1.1);
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
}  // namespace drover::physics::uniform_states_tests
