// tests/base/expression_calculus.cpp: derivatives and properties of expressions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "base/expression_support.hpp"
#include "base/refusal.hpp"

namespace drover::expression_calculus_tests {
namespace {

const std::array point{0.37, -0.82, 1.21, 0.7, 1.5, -0.5};

std::string derivative_text(const std::string& written) { return text_of(derivative(expression_of(written), 0)); }

TEST(Jump, is_where_sign_and_step_change_and_the_value_with_them) {
    const std::array at{0.0, 1.0, 1.0};
    for (const auto& [written, jumps] : {std::pair{"sign(x)", true},
                                         {"step(y - t)", true},
                                         {"x*sign(x)", false},
                                         {"sign(y)", false},
                                         {"abs(x)", false},
                                         {"max(y, t)", false},
                                         {"2*sign(x)*sign(x)", false},
                                         {"y + x*step(x)", false}})
        EXPECT_EQ(jumps_at(expression_of(written), at), jumps) << written;
    // Slopes of kinks jump, and those of their products with what vanishes there do not.
    EXPECT_TRUE(jumps_at(derivative(expression_of("abs(x)"), 0), at));
    EXPECT_TRUE(jumps_at(derivative(expression_of("max(y, t)"), 1), at));
    EXPECT_FALSE(jumps_at(derivative(expression_of("x*abs(x)"), 0), at));
}

TEST(Derivative, equals_the_central_difference_of_random_expressions) {
    std::mt19937 random(7);
    int compared = 0;
    while (compared < 500) {
        const Expression expression = random_expression(random, 4, true);
        for (int slot = 0; slot < 3; ++slot) {
            const double h = 1e-3;  // sixth order: error h^6 = 1e-18 times the seventh derivative
            std::array<double, 7> values{};
            for (int i = 0; i < 7; ++i) {
                auto there = point;
                there[static_cast<std::size_t>(slot)] += h * (i - 3);
                values[static_cast<std::size_t>(i)] = evaluate(expression, there);
            }
            const auto [v0, v1, v2, v3, v4, v5, v6] = values;
            const double difference = (45.0 * (v4 - v2) - 9.0 * (v5 - v1) + (v6 - v0)) / (60.0 * h);
            const double coarse = (8.0 * (v4 - v2) - (v5 - v1)) / (12.0 * h);
            const double size = 1.0 + std::abs(v3) + std::abs(difference);
            if (!std::isfinite(size) || std::abs(difference - coarse) > 1e-8 * size) continue;  // not resolved by h
            const double exact = evaluate(derivative(expression, slot), point);
            EXPECT_NEAR(exact, difference, 1e-8 * size) << text_of(expression) << " by " << slot;
            ++compared;
        }
    }
}

TEST(Derivative, is_simplified) {
    EXPECT_EQ(derivative_text("3"), "0");
    EXPECT_EQ(derivative_text("y"), "0");
    EXPECT_EQ(derivative_text("x"), "1");
    EXPECT_EQ(derivative_text("2 x + y"), "2");
    EXPECT_EQ(derivative_text("x^2"), "2 * x");
    EXPECT_EQ(derivative_text("x^3"), "3 * x^2");
    EXPECT_EQ(derivative_text("-W x y^2"), "-(W * y^2)");
    EXPECT_EQ(derivative_text("y / x"), "-(y / x / x)");
    EXPECT_EQ(derivative_text("sin(x) exp(y)"), "cos(x) * exp(y)");
}

TEST(Derivative, of_corners_and_jumps_is_that_beside_them) {
    EXPECT_EQ(derivative_text("abs(x)"), "sign(x)");
    EXPECT_EQ(derivative_text("step(x) + sign(x)"), "0");
    EXPECT_EQ(derivative_text("max(x, y)"), "step(x - y)");
    EXPECT_EQ(derivative_text("min(x, y)"), "step(y - x)");
    const Expression slope = derivative(expression_of("max(2 x, 3 x^2)"), 0);
    EXPECT_EQ(evaluate(slope, std::array{0.5}), 2.0);
    EXPECT_EQ(evaluate(slope, std::array{2.0}), 12.0);
}

TEST(Derivative, follows_product_chain_and_power_rules) {
    std::mt19937 random(11);
    for (int i = 0; i < 100; ++i) {
        const Expression f = random_expression(random, 3, true), g = random_expression(random, 3, true);
        const double of_product = evaluate(derivative(f * g, 0), point);
        const double by_rule = evaluate(derivative(f, 0) * g + f * derivative(g, 0), point);
        if (!std::isfinite(by_rule)) continue;
        EXPECT_NEAR(of_product, by_rule, 1e-12 * (1.0 + std::abs(by_rule)));
    }
    const Expression power = expression_of("x^y");
    EXPECT_NEAR(evaluate(derivative(power, 1), std::array{2.0, 3.0}), 8.0 * std::log(2.0), 1e-14);
    EXPECT_NEAR(evaluate(derivative(power, 0), std::array{2.0, 3.0}), 12.0, 1e-14);
}

TEST(Derivative, that_is_repeated_stays_of_the_size_of_the_expression_or_is_rejected_within_a_second) {
    std::string nested = "y", product = "x";
    for (int i = 0; i < 150; ++i) nested = "exp(x * " + nested + ")";
    for (int i = 0; i < 600; ++i) product += "*sin(x + y^" + std::to_string(i) + ")";
    for (const std::string& written : {nested, product}) {
        const auto start = std::chrono::steady_clock::now();
        Expression expression = expression_of(written);
        EXPECT_NO_THROW(expression = derivative(expression, 0)) << "one derivative is about as long as the product";
        const std::string said = refusal_of([&] {
            for (int i = 0; i < 12; ++i) expression = derivative(expression, 0, {"flock.toml", 3, 5});
        });
        EXPECT_NE(said.find("flock.toml:3:5: the expression has more than 20000 operations"), std::string::npos)
            << said;
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
    }
}

TEST(Bind, puts_a_number_in_the_place_of_a_slot) {
    EXPECT_EQ(text_of(bind(expression_of("W x^2 + y"), 3, 2.0)), "2 * x^2 + y");
    EXPECT_EQ(text_of(bind(expression_of("W x^2 + y"), 3, 0.0)), "y");
    EXPECT_TRUE(is_zero(bind(expression_of("-W x^2"), 3, 0.0)));
    EXPECT_NE(refusal_of([] {
                  static_cast<void>(bind(expression_of("x + 1 / W"), 3, 0.0, {"flock.toml", 4}));
              }).find("flock.toml:4: the expression divides 1 by zero; expected"),
              std::string::npos);
}

TEST(Expression, knows_its_slots_and_constants) {
    EXPECT_EQ(slots_of(expression_of("W x + rod_density")), (std::set{0, 3, 4}));
    EXPECT_EQ(constant_value(expression_of("2 * 3 + 0 x")), 6.0);
    EXPECT_EQ(constant_value(expression_of("x")), std::nullopt);
    EXPECT_TRUE(is_zero(expression_of("0 x + (y - y)")));
    EXPECT_FALSE(is_zero(expression_of("1 / (x - x)"))) << "infinite";
}

}  // namespace
}  // namespace drover::expression_calculus_tests
