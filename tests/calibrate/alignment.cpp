// tests/calibrate/alignment.cpp: the mean-field order against its distribution and its expansion at onset.
#include "drover/calibrate/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace drover::calibrate {
namespace {

TEST(MeanFieldOrder, is_the_mean_of_cos_theta_over_its_distribution) {
    for (const double g : {2.001, 2.5, 4.0, 30.0, 1500.0}) {
        const double order = order_of_alignment(g), x = g * order;
        double sum = 0.0, norm = 0.0;  // of exp(x (cos - 1)); the trapezoidal rule converges exponentially
        constexpr int points = 4096;
        for (int i = 0; i < points; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / points, weight = std::exp(x * (std::cos(angle) - 1.0));
            sum += weight * std::cos(angle);
            norm += weight;
        }
        // At x = 1500 the truncated series has an error of (1/x)^4.
        EXPECT_NEAR(order, sum / norm, 1e-11) << g;
    }
    for (const double g : {-3.0, 0.0, 1.0, 2.0}) EXPECT_EQ(order_of_alignment(g), 0.0);
    // P^2 = (g - 2)(1 - 5/6 (g - 2) + ...) above onset, so b/D_r = (g/2 - 1)/P^2 is continuous with g^2/8 = 1/2.
    for (const double beyond : {1e-2, 1e-3, 1e-4}) {
        EXPECT_NEAR(std::pow(order_of_alignment(2.0 + beyond), 2) / beyond, 1.0 - 5.0 / 6.0 * beyond,
                    beyond * beyond + 1e-9);
        EXPECT_NEAR(saturation_of_alignment(2.0 + beyond), 0.5, beyond);
    }
    EXPECT_NEAR(saturation_of_alignment(2.0 + 0.9e-6), saturation_of_alignment(2.0 + 1.1e-6), 1e-5);
    EXPECT_EQ(saturation_of_alignment(1.0), 0.125);
}

}  // namespace
}  // namespace drover::calibrate
