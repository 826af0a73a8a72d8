// tests/base/strip_program.cpp: expressions evaluated at many points.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/expression_support.hpp"
#include "base/refusal.hpp"

namespace drover::strip_program_tests {
namespace {

struct Points {
    std::array<std::vector<double>, 6> values;
    explicit Points(std::size_t size) {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> uniform(-1.5, 1.5);
        for (std::vector<double>& slot : values)
            for (std::size_t i = 0; i < size; ++i) slot.push_back(uniform(random));
    }
};

/// The program's values of expressions, written over `start`; slots at odd places are uniform if mixed.
std::vector<std::vector<double>> run(const std::vector<Expression>& expressions, const Points& points, std::size_t size,
                                     bool mixed, double start) {
    std::vector<std::vector<double>> results(expressions.size(), std::vector<double>(size + 1, start));
    std::vector<double*> out;
    for (std::vector<double>& result : results) out.push_back(result.data());
    std::array<const double*, 6> slots{};
    std::array<double, 6> uniform{};
    for (std::size_t s = 0; s < 6; ++s) {
        slots[s] = mixed && s % 2 == 1 ? nullptr : points.values[s].data();
        uniform[s] = points.values[s][0];
    }
    StripProgram(expressions).write(size, slots, uniform, out);
    return results;
}

double expected_value(const Expression& expression, const Points& points, std::size_t i, bool mixed) {
    std::array<double, 6> slots{};
    for (std::size_t s = 0; s < 6; ++s) slots[s] = points.values[s][mixed && s % 2 == 1 ? 0 : i];
    return evaluate(expression, slots);
}

void expect_same(const std::vector<Expression>& expressions, const Points& points, std::size_t size, bool mixed) {
    const double start = 0.25;
    const auto results = run(expressions, points, size, mixed, start);
    for (std::size_t k = 0; k < expressions.size(); ++k) {
        for (std::size_t i = 0; i < size; ++i) {
            const double expected = expected_value(expressions[k], points, i, mixed), found = results[k][i];
            if (!std::isfinite(expected)) continue;
            // 1e-10: a sum may cancel, and the program adds up in another order
            EXPECT_NEAR(found, expected, 1e-10 * (1.0 + std::abs(expected))) << text_of(expressions[k]) << " at " << i;
        }
        EXPECT_EQ(results[k][size], start) << "written beyond the end";
    }
}

TEST(StripProgram, equals_evaluate_for_random_expressions_at_any_number_of_points) {
    std::mt19937 random(23);
    const Points points(400);
    for (const std::size_t size : {0u, 1u, 2u, 7u, 63u, 64u, 65u, 127u, 128u, 129u, 300u, 400u})
        for (int i = 0; i < 25; ++i) {
            std::vector<Expression> expressions;
            for (int k = 0; k <= i % 3; ++k) expressions.push_back(random_expression(random, 4, true));
            expect_same(expressions, points, size, i % 2 == 0);
        }
}

TEST(StripProgram, equals_evaluate_for_every_function_and_pattern) {
    const Points points(200);
    for (const char* written : {"0",
                                "3",
                                "x",
                                "W",
                                "-x",
                                "x + W",
                                "W + W",
                                "x - y",
                                "y - W",
                                "W - x",
                                "x y",
                                "W x",
                                "x / y",
                                "W / x",
                                "x / W",
                                "x y + t",
                                "x y + W",
                                "W y + t",
                                "t - x y",
                                "x y - t",
                                "W - x y",
                                "W x - 1",
                                "2 W x y - 3 t^2",
                                "x^0",
                                "x^1",
                                "x^2",
                                "x^3",
                                "x^7",
                                "x^-1",
                                "x^-2",
                                "x^64",
                                "x^65",
                                "abs(x)^0.5",
                                "abs(x)^-0.5",
                                "abs(x)^1.5",
                                "abs(x)^y",
                                "abs(x)^W",
                                "W^x",
                                "abs(x) + step(y) + sign(t)",
                                "max(x, y) min(x, W) + max(W, y)",
                                "exp(x) + sin(y) cos(t) - tan(x)",
                                "log(abs(x)) + sqrt(abs(y)) + atan(t) + atan2(x, y) + atan2(W, y)",
                                "sinh(x) cosh(y) tanh(t)",
                                "exp(W) + x",
                                "exp(W)",
                                "W order_x",
                                "-(W + t (x x + y y)) x",
                                "x*x*x + (x*x*x)^2",
                                "(x + y) / (x + y + 5)",
                                "x - (y - (t - (W - 1)))",
                                "-(-(x - y) - t)",
                                "W + 2 t + 1",
                                "W + 2",
                                "W - x + W",
                                "rod_density order_x - W rod_density"})
        for (const bool mixed : {false, true}) expect_same({expression_of(written)}, points, 200, mixed);
}

TEST(StripProgram, of_factored_expressions_has_their_values) {
    std::mt19937 random(29);
    const Points points(60);
    const auto expect_factored = [&](const std::vector<Expression>& expressions) {
        const std::vector<Expression> found = factored(expressions);
        for (std::size_t k = 0; k < expressions.size(); ++k)
            for (std::size_t i = 0; i < 60; ++i) {
                const double expected = expected_value(expressions[k], points, i, false);
                const bool has_jump = text_of(expressions[k]).find("atan2") != std::string::npos;  // at 0 and -0
                if (!std::isfinite(expected) || has_jump) continue;
                // 1e-10: sums of large terms may cancel, and are added up in another order
                EXPECT_NEAR(expected_value(found[k], points, i, false), expected, 1e-10 * (1.0 + std::abs(expected)))
                    << text_of(expressions[k]) << " became " << text_of(found[k]);
            }
    };
    for (int i = 0; i < 400; ++i) {
        std::vector<Expression> expressions;
        for (int k = 0; k <= i % 3; ++k) expressions.push_back(random_expression(random, 5, true));
        expect_factored(expressions);
    }
    for (const char* written :
         {"0", "x - x", "2", "-x - y", "-(2 x + 3) y + 3 y", "x (W + 1) - x W - x", "x / (2 t) + y / (2 t) - 3 / (2 t)",
          "1 - (1 - x (1 - x (1 - x)))", "x x y - x y y + x y", "0.1 x + 0.2 x - 0.3 x", "(x - 1) (y - 1) - x y"})
        expect_factored({expression_of(written), expression_of("x + 1")});
}

TEST(Factored, needs_no_more_operations_where_linear_parts_cancel_and_components_share_a_factor) {
    const std::vector<Expression> found =
        factored(std::vector{expression_of("-(0.4 + 0.8 (x x + y y)) x + 0.4 x - 0.5 t x"),
                             expression_of("-(0.4 + 0.8 (x x + y y)) y + 0.4 y - 0.5 t y")});
    EXPECT_EQ(text_of(found[0]), "-(x * (0.8 * (x * x + y * y) + 0.5 * t))");
    EXPECT_EQ(text_of(found[1]), "-(y * (0.8 * (x * x + y * y) + 0.5 * t))");
}

TEST(StripProgram, shares_what_several_outputs_have_in_common) {
    const Points points(150);
    expect_same({expression_of("-(W + t (x x + y y)) x"), expression_of("-(W + t (x x + y y)) y"),
                 expression_of("x x + y y"), expression_of("x x + y y")},
                points, 150, true);
}

TEST(StripProgram, needs_few_registers_or_shorter_chunks_for_any_expression) {
    const Points points(200);
    std::string wide = "1", sum = "x";
    for (int i = 1; i < 120; ++i) wide = "(sin(x + " + std::to_string(i) + ") + " + wide + " y / 2)";
    for (int i = 1; i < 400; ++i) sum += " + cos(y - 0." + std::to_string(i) + ")";
    std::string both = "0", shared;
    for (int i = 0; i < 100; ++i) shared += (i ? "+" : "") + ("sin(x+" + std::to_string(i) + ")");
    for (int i = 0; i < 100; ++i) both += "+exp(sin(x+" + std::to_string(i) + "))";
    expect_same({expression_of(wide), expression_of(sum)}, points, 200, false);
    expect_same({expression_of("(" + shared + ")^2"), expression_of(both)}, points, 200, false);
}

TEST(StripProgram, of_too_many_operations_is_rejected) {
    std::vector<Expression> expressions;
    for (int i = 0; i < 10; ++i) {
        std::string sum = "x";
        for (int j = 0; j < 250; ++j) sum += "+sin(x+" + std::to_string(i) + "." + std::to_string(j) + ")";
        expressions.push_back(expression_of(sum));
    }
    EXPECT_NE(refusal_of([&] { static_cast<void>(StripProgram(expressions)); }).find("more than 4096 operations"),
              std::string::npos);
}

}  // namespace
}  // namespace drover::strip_program_tests
