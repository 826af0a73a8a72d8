// tests/physics/uniform_states.cpp: stationary states do not change under the solver, and all of them are found.
#include <gtest/gtest.h>

#include "flock_model.hpp"
#include "full_model.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::uniform_states_tests {
namespace {

constexpr numerics::Grid grid{8, 8, 5.0, 5.0};

/// The largest rate of the solver's own equations in a uniform state, whatever the form.
double largest_rate(const Equations& e, const UniformPoint& point) {
    Threads threads(1);
    numerics::WholeRate rate = whole_rate(e, grid, {point.bead_density, point.rod_density}, threads);
    numerics::Spectra state(grid, numerics::components(layout(physics::form(e.model))));
    const auto put = [&](int component, double value) {
        if (component >= 0) state[component][0] = value;
    };
    put(physics::form(e.model).bead_density, point.bead_density);
    put(physics::form(e.model).rod_density, point.rod_density);
    if (physics::form(e.model).bead_velocity >= 0) {
        put(physics::form(e.model).bead_velocity, point.velocity.x());
        put(physics::form(e.model).bead_velocity + 1, point.velocity.y());
    }
    put(physics::form(e.model).polar_order, point.order.x());
    put(physics::form(e.model).polar_order + 1, point.order.y());
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

TEST(StationaryStates, with_coefficients_from_a_table_turn_freely) {
    // The slopes of a table are differences of large numbers in some states, where they have rounding errors alone.
    Model linear{.fields = {.bead_density = true, .bead_velocity = "dynamic"},
                 .uniform = {.rod_density = 0.03, .bead_density = 1.0, .rod_area = 4.0, .bead_area = 0.5},
                 .drag = {.coefficient = 1.0},
                 .relaxation = {.saturation = 1.0},
                 .weathercock = {.strength = 1.0}};
    linear.table = {.bead_density = {0.4, 1.0, 1.6},
                    .rod_density = {0.01, 0.05},
                    .columns = {{"relaxation.rate", {{1.0, 1.0, 1.0, 1.0, 1.0, 1.0}, {}}},
                                {"driving.strength", {{0.4, 0.4, 1.0, 1.0, 1.6, 1.6}, {}}}}};
    Model curved = tabulated().model;
    curved.force.kind = "none";
    curved.orienting_field = {};
    for (const Model& model : {linear, curved}) EXPECT_TRUE(theory::turns_freely(Equations(model).solver()));
    curved.orienting_field = tabulated().model.orienting_field;
    EXPECT_FALSE(theory::turns_freely(Equations(curved).solver()));
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

TEST(StationaryStates, of_beads_without_drag_are_at_rest_or_do_not_exist) {
    EXPECT_EQ(stationary_states(Equations(flock_model({.gamma = 0.0}))).states.size(), 1u);  // without order
    Model pushed = flock_model({.gamma = 0.0, .alpha = 0.0});
    pushed.force = {.kind = "uniform", .x = 1.0};
    EXPECT_TRUE(stationary_states(Equations(pushed)).states.empty());
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
    EXPECT_NE(stationary_states(Equations(model)).no_order, "");
}

}  // namespace
}  // namespace drover::physics::uniform_states_tests
