// tests/physics/regimes.cpp: regimes from margins, area fractions as axes, and the state nearest to a run.
#include "drover/physics/regimes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drover/physics/predictions.hpp"

namespace drover::physics::regimes_tests {
namespace {

TEST(Regime, follows_from_the_signs_of_the_margins) {
    EXPECT_EQ(regime_of(NAN, NAN, NAN, NAN), Regime::undefined);
    EXPECT_EQ(regime_of(1.0, 1.0, NAN, NAN), Regime::isotropic);
    EXPECT_EQ(regime_of(1.0, -1.0, NAN, NAN), Regime::separating);
    EXPECT_EQ(regime_of(-1.0, NAN, NAN, NAN), Regime::undefined);
    EXPECT_EQ(regime_of(-1.0, NAN, 1.0, 1.0), Regime::flock);
    EXPECT_EQ(regime_of(-1.0, NAN, -1.0, -1.0), Regime::banding);
    EXPECT_EQ(regime_of(-1.0, NAN, 1.0, -1.0), Regime::oblique);
    EXPECT_TRUE(regime_legend().starts_with("-1 not defined, 0 isotropic, "));
}

TEST(AreaFraction, as_an_axis_sets_the_density) {
    const AreaFraction* fraction = find_area_fraction("bead_area_fraction");
    ASSERT_NE(fraction, nullptr);
    EXPECT_EQ(find_area_fraction("bead_density"), nullptr);
    Model model;
    area_fraction_axis(*fraction, 0.5, 0.1, 0.9).set(model, 0.25);
    EXPECT_EQ(model.uniform.bead_density, 0.5);
    EXPECT_TRUE(is_same_axis("bead_area_fraction", "uniform.bead_density"));
    EXPECT_FALSE(is_same_axis("bead_area_fraction", "rod_area_fraction"));
    EXPECT_FALSE(is_same_axis("drag.coefficient", "driving.strength"));
}

TEST(NearestState, is_chosen_by_the_size_of_the_order_or_where_a_field_fixes_it_by_its_direction) {
    const auto state = [](double x) {
        StationaryState result;
        result.point.order = {x, 0.0};
        return result;
    };
    const std::vector<Eigen::Vector2d> samples{{0.0, 0.9}, {-0.9, 0.0}};  // of size 0.9, with a mean of 0.6
    const StationaryStates free{.states = {state(0.0), state(1.0)}, .no_order = ""};
    EXPECT_EQ(nearest_state(free, samples), &free.states[1]);
    const StationaryStates held{.states = {state(1.0), state(-0.8)}, .no_order = ""};
    EXPECT_EQ(nearest_state(held, samples), &held.states[1]);
    EXPECT_EQ(nearest_state({}, samples), nullptr);
}

}  // namespace
}  // namespace drover::physics::regimes_tests
