// tests/base/expression_support.hpp: a vocabulary and random expressions for tests.
#pragma once
#include <random>
#include <string>

#include "drover/base/expression.hpp"

namespace drover {

/// Slots 0 to 5: x, y, t, W, rod_density, and the order; 6 to 8 derivatives.
inline const Vocabulary& test_vocabulary() {
    static const Vocabulary vocabulary{
        .variables = {{"x", 0}, {"y", 1}, {"t", 2}, {"W", 3}, {"rod_density", 4}, {"order_x", 5}},
        .operators = {{"d_x", {{"rod_density", 6}}}, {"d_y", {{"rod_density", 7}}}, {"div", {{"order", 8}}}},
        .constants = {{"two", 2.0}}};
    return vocabulary;
}

inline Expression expression_of(const std::string& written) { return parse_expression(written, test_vocabulary()); }

/// A text of random operations on x, y, t and numbers, `depth` deep; smooth: without jumps and corners.
inline std::string random_text(std::mt19937& random, int depth, bool smooth) {
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    const auto part = [&] { return random_text(random, depth - 1, smooth); };
    if (depth == 0) {
        constexpr const char* leaves[] = {"x", "y", "t", "x", "y", "0.7", "1.3", "2", "pi", "(-0.4)"};
        return leaves[below(10)];
    }
    constexpr const char* functions[] = {"cos",  "sin", "tanh", "atan", "exp",  "cosh", "sinh",
                                         "sqrt", "log", "tan",  "abs",  "step", "sign"};
    switch (below(10)) {
        case 0: return "(" + part() + " + " + part() + ")";
        case 1: return "(" + part() + " - " + part() + ")";
        case 2: return part() + " * " + part();
        case 3: return "(" + part() + ")" + " (" + part() + ")";
        case 4: return "(" + part() + ") / (1.5 + (" + part() + ")^2)";
        case 5: return "-(" + part() + ")";
        case 6: return "(" + part() + ")^" + std::to_string(below(5));
        case 7: return std::string(functions[below(smooth ? 7 : 13)]) + "(" + part() + ")";
        case 8: return std::string(smooth ? "atan2" : below(2) ? "max" : "min") + "(" + part() + ", " + part() + ")";
        default: return "(1.1 + (" + part() + ")^2)^(" + part() + " / 4)";
    }
}

/// A random expression that parses: texts with infinite constants are drawn again.
inline Expression random_expression(std::mt19937& random, int depth, bool smooth) {
    for (;;) try {
            return expression_of(random_text(random, depth, smooth));
        } catch (const Error&) {
        }
}

}  // namespace drover
