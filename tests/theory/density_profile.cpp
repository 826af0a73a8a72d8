// tests/theory/density_profile.cpp: plateaus and waves of known shape.
#include "theory/binodal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace drover::theory {
namespace {

constexpr double length = 20.0;

DensityProfile profile_of(int points, double (*density)(double x)) {
    std::vector<double> values;
    for (int i = 0; i < points; ++i) values.push_back(density(length * i / points));
    return density_profile(values, length);
}

/// Straight lines between points a distance h apart are right to second order in h, here to h^2/2 in mm.
TEST(DensityProfile, has_a_width_that_does_not_depend_on_where_the_points_are) {
    for (const int points : {32, 33, 100}) {
        const double h = length / points;
        const auto cosine = [](double x) { return 3.0 + std::cos(2.0 * std::numbers::pi * (x - 1.234) / length); };
        EXPECT_NEAR(profile_of(points, cosine).width, 0.5 * length, 0.5 * h * h) << points;
    }
    // A plateau between two fronts 7.3 mm apart, one of which the period of the line wraps.
    const DensityProfile band = profile_of(200, [](double x) {
        const auto front = [](double at) { return std::tanh(at / 0.4); };
        return front(x - 15.1) - front(x - 2.4 - length) + front(x + 4.9) - front(x - 2.4);
    });
    EXPECT_NEAR(band.width, 7.3, 1e-3);
    EXPECT_TRUE(band.low_is_flat && band.high_is_flat);
    EXPECT_NEAR(band.high - band.low, 2.0, 1e-6);
}

TEST(DensityProfile, of_a_uniform_density_has_no_width) {
    const DensityProfile uniform = profile_of(16, [](double) { return 0.6; });
    EXPECT_EQ(uniform.width, 0.0);
    EXPECT_EQ(uniform.low, 0.6);
}

}  // namespace
}  // namespace drover::theory
