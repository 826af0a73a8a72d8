// tests/base/formula.cpp: formulas of a scene as functions of x and y.
#include "drover/base/formula.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace drover {
namespace {

double value(const std::string& written, double x = 0.0, double y = 0.0) { return Formula(written)(x, y); }

TEST(Formula, follows_the_rules_of_arithmetic) {
    EXPECT_EQ(value("2 + 3 * 4"), 14.0);
    EXPECT_EQ(value("(2 + 3) * 4"), 20.0);
    EXPECT_EQ(value("8 / 4 / 2"), 1.0);
    EXPECT_EQ(value("2 - 3 - 4"), -5.0);
    EXPECT_EQ(value("2 ^ 3 ^ 2"), 512.0) << "powers bind to the right";
    EXPECT_EQ(value("-2 ^ 2"), -4.0) << "and before a minus";
    EXPECT_EQ(value("2 ^ -1"), 0.5);
    EXPECT_EQ(value("--3"), 3.0);
    EXPECT_EQ(value("1.5e-3"), 1.5e-3);
}

TEST(Formula, knows_x_y_pi_and_functions) {
    EXPECT_EQ(value("x - 2*y", 5.0, 1.0), 3.0);
    EXPECT_DOUBLE_EQ(value("cos(2*pi*x/8) + sin(y)", 1.0, 0.3), std::cos(std::numbers::pi / 4.0) + std::sin(0.3));
    EXPECT_DOUBLE_EQ(value("tanh(x) + cosh(x) - sinh(x) + exp(-x) + log(x) + sqrt(x) + tan(x)", 0.7),
                     std::tanh(0.7) + std::cosh(0.7) - std::sinh(0.7) + std::exp(-0.7) + std::log(0.7) +
                         std::sqrt(0.7) + std::tan(0.7));
    EXPECT_EQ(value("max(x, y) - min(x, y) + abs(y) + step(x) + step(y)", 2.0, -1.0), 5.0);
}

TEST(Formula, that_cannot_be_read_is_refused_with_its_place_and_the_character) {
    for (const auto& [written, character] : {std::pair{"", "(character 1)"},
                                             {"2 +", "(character 4)"},
                                             {"2 3", "(character 3)"},
                                             {"(2", "(character 3)"},
                                             {"z", "(character 1)"},
                                             {"sin x", "(character 5)"},
                                             {"max(1)", "(character 6)"},
                                             {"2 * foo(3)", "(character 5)"},
                                             {"1..2", "(character 3)"},
                                             {"2)", "(character 2)"}})
        try {
            static_cast<void>(Formula(written, {.file = "flock.toml", .line = 3}));
            ADD_FAILURE() << written << " was read";
        } catch (const Error& error) {
            const std::string said = error.what();
            EXPECT_EQ(said.rfind("flock.toml:3: ", 0), 0u) << said;
            EXPECT_NE(said.find(character), std::string::npos) << said;
            EXPECT_NE(said.find("expected"), std::string::npos) << said;
        }
}

TEST(Formula, knows_decimal_numbers_alone_and_says_which_letter_it_expected) {
    EXPECT_THROW(Formula("0x10"), Error);
    EXPECT_THROW(Formula("1e999"), Error);
    try {
        static_cast<void>(Formula("(2"));
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("expected \")\""), std::string::npos) << error.what();
    }
}

TEST(Formula, longer_than_the_stack_can_hold_is_refused) {
    std::string sum = "1";
    for (int i = 0; i < 10000; ++i) sum += "+1";
    EXPECT_THROW(static_cast<void>(Formula(sum)), Error);
}

TEST(Formula, nested_beyond_reason_is_refused_and_not_the_end_of_the_stack) {
    EXPECT_THROW(Formula(std::string(100000, '(')), Error);
    EXPECT_THROW(Formula(std::string(100000, '-') + "1"), Error);
}

}  // namespace
}  // namespace drover
