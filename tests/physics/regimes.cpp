// tests/physics/regimes.cpp: regimes from margins, and area fractions as axes.
#include "drover/physics/regimes.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace drover::physics::regimes_tests
