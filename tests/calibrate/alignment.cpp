// tests/calibrate/alignment.cpp: the mean-field order against its distribution and its expansion at onset.
#include "calibrate/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "drover/base/random.hpp"

namespace drover::calibrate::alignment_tests {
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

TEST(MeanFieldOrder, of_a_flow_that_bends_is_the_largest_that_holds_itself) {
    // At g = 1.6 < 2 a flow that grows with the order keeps an order that is there; a smaller one does not.
    for (const auto& [g, cubic] : {std::pair{1.6, 3.0}, std::pair{2.5, -1.5}, std::pair{3.0, 2.0}}) {
        const double order = order_of_alignment(g, cubic), x = g * order + cubic * std::pow(order, 3);
        EXPECT_GT(order, 0.3);
        EXPECT_NEAR(order, std::cyl_bessel_i(1.0, x) / std::cyl_bessel_i(0.0, x), 1e-12) << g;
        for (double above = order + 1e-6; above < 1.0; above += 0.01) {
            const double pull = g * above + cubic * std::pow(above, 3);
            EXPECT_LT(pull > 0.0 ? std::cyl_bessel_i(1.0, pull) / std::cyl_bessel_i(0.0, pull) : 0.0, above);
        }
        if (g > 2.0) {  // the uniform flock of the equations, over D_r
            const double b = saturation_of_alignment(g, cubic);
            EXPECT_NEAR(0.5 * g - 1.0 + (0.5 * cubic - b) * order * order, 0.0, 1e-12);
        }
        EXPECT_NEAR(order_of_rods(20000, g + 0.5, cubic).mean, order_of_alignment(g + 0.5, cubic), 1e-3);
    }
    EXPECT_EQ(order_of_alignment(1.6, 0.5), 0.0);
    // Without a flock the cubic of the equations, b - g3/2, must not let a fluctuation grow.
    for (const double g : {0.3, 1.2, 2.0})
        for (const double cubic : {-1.0, 0.4, 3.0}) EXPECT_GE(saturation_of_alignment(g, cubic) - 0.5 * cubic, 0.0);
}

TEST(Concentration, is_the_inverse_of_the_order) {
    for (const double kappa : {1e-9, 0.01, 1.0, 7.0, 79.0, 81.0, 2000.0}) {
        const double order = kappa < 500.0 ? std::cyl_bessel_i(1.0, kappa) / std::cyl_bessel_i(0.0, kappa)
                                           : 1.0 - 0.5 / kappa - 0.125 / (kappa * kappa);
        // Near 1 the order has fewer digits of kappa: dP/dkappa = 1/(2 kappa^2).
        EXPECT_NEAR(concentration_of_order(order), kappa, 1e-9 * kappa * (1.0 + 1e-4 * kappa * kappa)) << kappa;
        EXPECT_EQ(concentration_of_order(-order), -concentration_of_order(order));
    }
    EXPECT_EQ(concentration_of_order(0.0), 0.0);
    EXPECT_TRUE(std::isnan(concentration_of_order(1.0)));
}

TEST(OrderOfRods, is_that_of_sampled_directions) {
    // Random directions, weighted by exp(g N P^2/2 + g3 N P^4/4).
    constexpr int samples = 40000;
    for (const int rods : {6, 25}) {
        std::vector<double> angles(static_cast<std::size_t>(samples * rods));
        fill_uniform({.seed = 1, .stream = Stream::test}, 0, 1, angles);
        for (const auto& [alignment, cubic] : {std::pair{0.0, 0.0}, {1.2, 0.0}, {0.8, 0.0}, {0.8, 1.5}}) {
            double norm = 0.0, mean = 0.0, square = 0.0;
            for (int i = 0; i < samples; ++i) {
                double x = 0.0, y = 0.0;
                for (int r = 0; r < rods; ++r) {
                    const double angle = 2.0 * std::numbers::pi * angles[static_cast<std::size_t>(i * rods + r)];
                    x += std::cos(angle) / rods, y += std::sin(angle) / rods;
                }
                const double order = std::hypot(x, y),
                             weight =
                                 std::exp(rods * (0.5 * alignment * order * order + 0.25 * cubic * std::pow(order, 4)));
                norm += weight, mean += weight * order, square += weight * order * order;
            }
            mean /= norm, square /= norm;
            const RodsOrder found = order_of_rods(rods, alignment, cubic);
            // The saddle point is good to 2 % at 6 rods and 0.5 % at 25; the weights leave an eighth of the samples.
            const double error = mean * (0.02 * 6.0 / rods) + 3.0 * found.deviation / std::sqrt(samples / 8);
            EXPECT_NEAR(found.mean, mean, error) << rods << " " << alignment;
            EXPECT_NEAR(found.deviation, std::sqrt(square - mean * mean), error) << rods << " " << alignment;
        }
    }
}

TEST(OrderOfRods, is_the_mean_field_for_many_rods) {
    for (const double g : {2.5, 4.0}) EXPECT_NEAR(order_of_rods(20000, g).mean, order_of_alignment(g), 1e-3);
}

}  // namespace
}  // namespace drover::calibrate::alignment_tests
