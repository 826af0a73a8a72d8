// tests/base/expression.cpp: expressions as text: values, grammar and errors.
#include "drover/base/expression.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include "base/expression_support.hpp"
#include "base/refusal.hpp"

namespace drover::expression_tests {
namespace {

double value(const std::string& written, double x = 0.0, double y = 0.0) {
    return evaluate(expression_of(written), std::array{x, y, 0.3, 0.7, 1.5, -0.5, 2.0, 3.0, 5.0});
}

TEST(Expression, follows_the_rules_of_arithmetic) {
    EXPECT_EQ(value("2 + 3 * 4"), 14.0);
    EXPECT_EQ(value("(2 + 3) * 4"), 20.0);
    EXPECT_EQ(value("8 / 4 / 2"), 1.0);
    EXPECT_EQ(value("2 - 3 - 4"), -5.0);
    EXPECT_EQ(value("2 ^ 3 ^ 2"), 512.0) << "powers bind to the right";
    EXPECT_EQ(value("-2 ^ 2"), -4.0) << "and before a minus";
    EXPECT_EQ(value("2 ^ -1"), 0.5);
    EXPECT_EQ(value("--3"), 3.0);
    EXPECT_EQ(value("1.5e-3"), 1.5e-3);
    EXPECT_EQ(value(".5 + 2."), 2.5);
}

TEST(Expression, has_the_values_of_its_functions) {
    EXPECT_EQ(value("x - 2*y", 5.0, 1.0), 3.0);
    EXPECT_DOUBLE_EQ(value("cos(2*pi*x/8) + sin(y)", 1.0, 0.3), std::cos(std::numbers::pi / 4.0) + std::sin(0.3));
    EXPECT_DOUBLE_EQ(value("tanh(x) + cosh(x) - sinh(x) + exp(-x) + log(x) + sqrt(x) + tan(x) + atan(x)", 0.7),
                     std::tanh(0.7) + std::cosh(0.7) - std::sinh(0.7) + std::exp(-0.7) + std::log(0.7) +
                         std::sqrt(0.7) + std::tan(0.7) + std::atan(0.7));
    EXPECT_EQ(value("max(x, y) - min(x, y) + abs(y) + step(x) + step(y)", 2.0, -1.0), 5.0);
    EXPECT_EQ(value("sign(x) + 10 sign(y) + 100 sign(0)", 2.0, -1.0), -9.0);
    EXPECT_EQ(value("atan2(x, y) + pow(x, 3)", 2.0, -1.0), std::atan2(2.0, -1.0) + 8.0);
}

TEST(Expression, performs_the_operations_of_the_text_in_its_order) {
    const double x = 0.1, y = 0.7;  // other orders give other last digits
    EXPECT_EQ(value("x + y + 0.3 - x", x, y), x + y + 0.3 - x);
    EXPECT_EQ(value("x * 3 * y / 7 * x", x, y), x * 3.0 * y / 7.0 * x);
    EXPECT_EQ(value("2 * pi * x / 8", x, y), 2.0 * std::numbers::pi * x / 8.0);
    EXPECT_EQ(value("x^3 + y^2", x, y), std::pow(x, 3.0) + std::pow(y, 2.0));
    EXPECT_TRUE(std::signbit(value("0 * x", -1.0))) << "0 x is not replaced by 0";
}

TEST(Expression, takes_juxtaposed_factors_as_a_product) {
    EXPECT_EQ(value("2 x", 5.0), 10.0);
    EXPECT_EQ(value("2x y^2", 5.0, 3.0), 90.0);
    EXPECT_EQ(value("3(x + 1)", 5.0), 18.0);
    EXPECT_EQ(value("x(y + 1)", 5.0, 3.0), 20.0) << "x is not a function";
    EXPECT_EQ(value("(x + 1)(y - 1)", 5.0, 3.0), 12.0);
    EXPECT_EQ(value("x / y x", 6.0, 3.0), 12.0) << "binds like *";
    EXPECT_EQ(value("-W order_x y^2", 0.0, 2.0), -(0.7) * -0.5 * 4.0);
    EXPECT_EQ(value("2 sin(x) cos(y) two", 1.0, 2.0), 2.0 * std::sin(1.0) * std::cos(2.0) * 2.0);
}

TEST(Expression, gives_infinite_or_undefined_values_where_its_operations_do) {
    EXPECT_EQ(value("1 / x"), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(value("log(x)", -1.0)));
    EXPECT_TRUE(std::isnan(value("x / x")));
}

TEST(Expression, that_cannot_be_parsed_is_rejected_at_the_column_of_the_character) {
    struct Case {
        const char* text;
        int character;
        const char* said;
    };
    for (const auto& [text, character, said] :
         {Case{"", 1, "its end"},
          {"2 +", 4, "expected a number, a name, a function or \"(\""},
          {"2 3", 3, "\"3\" at character 3; expected an operator"},
          {"(2", 3, "expected \")\""},
          {"z", 1, "expected one of W, order_x, rod_density, t, x, y, two, pi"},
          {"2 x + rod_densty", 7, "\"rod_densty\" at character 7; expected rod_density (did you mean that?)"},
          {"sin x", 5, "expected \"(\" after the function sin"},
          {"max(1)", 6, "\",\" and a second argument of max"},
          {"sin(x, y)", 6, "\")\" after the argument of sin"},
          {"2 * foo(3)", 5, "foo"},
          {"1..2", 3, "\".\""},
          {"2)", 2, "expected an operator"},
          {"0x10", 2, "x10"},
          {"x + 1e999", 5, "a number between"},
          {"x + 1/0", 6, "divides 1 by zero"},
          {"x / (1 - 1)", 3, "divides by zero"},
          {"x + log(-1)", 5, "log(-1) in the expression is"},
          {"1 + 10^400", 7, "pow(10, 400) in the expression is inf"},
          {"x + \xCF\x81 y", 5, "\"\xCF\x81\""}}) {
        const auto parse = [&, written = std::string(text)](int column) {
            return refusal_of([&] {
                static_cast<void>(parse_expression(written, test_vocabulary(), {"flock.toml", 3, column}));
            });
        };
        EXPECT_EQ(parse(20).rfind("flock.toml:3:" + std::to_string(19 + character) + ": ", 0), 0u) << parse(20);
        EXPECT_EQ(parse(0).rfind("flock.toml:3: ", 0), 0u) << parse(0);
        EXPECT_NE(parse(20).find(said), std::string::npos) << parse(20);
        EXPECT_NE(parse(20).find("expected"), std::string::npos) << parse(20);
    }
}

TEST(Expression, may_be_nested_200_levels_deep) {
    const auto nested = [](std::size_t depth) { return std::string(depth, '(') + "x" + std::string(depth, ')'); };
    EXPECT_EQ(value(nested(200), 3.0), 3.0);
    EXPECT_THROW(value(nested(201)), Error);
}

std::string repeated(const std::string& part, int times) {
    std::string result;
    for (int i = 0; i < times; ++i) result += part;
    return result;
}

/// The texts of the file and those that are too long to write down.
std::vector<std::string> hostile_texts() {
    std::vector<std::string> texts{
        "", " ", "\n", "\t\t", std::string(1, '\0'), "x" + std::string(1, '\0') + "y", "\xff\xfe", "x\x80"};
    std::ifstream file(DROVER_TESTS "/base/hostile_expressions.txt");
    for (std::string line; std::getline(file, line);)
        if (line[0] != '#') texts.push_back(line);
    for (const char* part :
         {"(", ")", "-", "+", "x^", "x+", "x*", "x", "1", " ", "sin(", "max(x,", "2^-", "x x ", "(x)"})
        for (const int times : {5000, 1000000}) texts.push_back(repeated(part, times) + "+");
    texts.push_back(repeated("(", 300) + "x" + repeated(")", 300));
    texts.push_back(repeated("sin(", 300) + "x" + repeated(")", 300));
    texts.push_back(repeated("-", 300) + "x");
    texts.push_back(repeated("x^", 300) + "x");
    texts.push_back(repeated("x+", 500000) + "x");
    texts.push_back(repeated("exp(x*", 250) + "y" + repeated(")", 250));
    return texts;
}

TEST(Expression, that_is_malformed_or_hostile_is_rejected_with_a_message) {
    const std::vector<std::string> texts = hostile_texts();
    EXPECT_GE(texts.size(), 200u);
    for (const std::string& text : texts) {
        EXPECT_THROW(static_cast<void>(expression_of(text)), Error) << text.substr(0, 80);
        const std::string said = refusal_of([&] { static_cast<void>(expression_of(text)); });
        EXPECT_LT(said.size(), 1000u);
        EXPECT_NE(said.find("expected"), std::string::npos) << said;
    }
}

}  // namespace
}  // namespace drover::expression_tests
