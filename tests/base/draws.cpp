// tests/base/draws.cpp: draws of uncertain numbers, and the quantiles of their results.
#include "base/draws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace drover::draws_tests {
namespace {

TEST(Draws, of_one_number_have_its_error_and_those_of_two_are_independent) {
    const auto draws = [](std::uint64_t number, std::uint64_t part) {
        return normal_draws(random_ranks(number, part, 400));
    };
    const std::vector<double> x = draws(1, 0), y = draws(1, 1);
    EXPECT_EQ(x, draws(1, 0));
    EXPECT_NE(x, draws(2, 0));
    EXPECT_NEAR(half_width(x), 1.0, 1e-4);  // parts of 1/400: the normal law is straight between their middles
    double product = 0.0;
    std::vector<double> sum;
    for (std::size_t k = 0; k < x.size(); ++k) product += x[k] * y[k] / 400.0, sum.push_back(x[k] + y[k]);
    EXPECT_NEAR(product, 0.0, 4.0 / 20.0);                               // a correlation has the error 1/sqrt(400)
    EXPECT_NEAR(half_width(sum), std::sqrt(2.0), 0.2 * std::sqrt(2.0));  // four errors of 5 %
}

TEST(Draws, in_the_order_of_numbers_keep_it_whatever_these_are) {
    const std::vector<double> order{-5.0, 1e9, 2.0, 2.0}, draws = normal_draws(order);
    EXPECT_EQ(ranks_of(order), (std::vector<double>{0.0, 3.0, 1.0, 2.0}));
    EXPECT_EQ(draws, normal_draws(ranks_of(order)));
    EXPECT_NEAR(draws[0], -1.1503, 1e-4);  // 1/8 of the normal distribution lies below
    EXPECT_NEAR(draws[1], -draws[0], 1e-15);
    EXPECT_NEAR(draws[2], -0.3186, 1e-4);  // and 3/8 below this
}

TEST(Draws, have_quantiles_also_with_infinite_values) {
    const double far = HUGE_VAL;
    const std::vector<double> values{-far, 1.0, 2.0, 3.0, far};
    EXPECT_EQ(quantile(values, 0.5), 2.0);
    EXPECT_EQ(quantile(values, 0.0), -far);
    EXPECT_EQ(quantile(values, 0.98), far);
    EXPECT_NEAR(quantile({0.0, 1.0}, 0.5), 0.5, 1e-15);
}

TEST(Draws, tell_how_many_errors_a_number_lies_above_zero) {
    const auto deviation = [](double value, double error) {
        std::vector<double> values = normal_draws(random_ranks(3, 0, 1000));
        for (double& one : values) one = value + error * one;
        std::sort(values.begin(), values.end());
        return over_error(values);
    };
    // Half a draw of 1000 is 0.0005/0.24 errors at one of them.
    EXPECT_NEAR(deviation(1.0, 1.0), 1.0, 3e-3);
    EXPECT_NEAR(deviation(-0.5, 1.0), -0.5, 3e-3);
    EXPECT_NEAR(deviation(8.0, 1.0), 8.0, 0.1);
    EXPECT_GT(deviation(1.0, 0.0), 1e6);
    EXPECT_LT(deviation(-1.0, 0.0), -1e6);
}

}  // namespace
}  // namespace drover::draws_tests
