// tests/base/expression_support.hpp: a vocabulary, random expressions and texts of expressions for tests.
#pragma once
#include <random>
#include <string>

#include "base/expression_graph.hpp"

namespace drover {

/// Slots 0 to 5: x, y, t, W, rod_density, and the order.
inline const Vocabulary& test_vocabulary() {
    static const Vocabulary vocabulary{
        .variables = {{"x", 0}, {"y", 1}, {"t", 2}, {"W", 3}, {"rod_density", 4}, {"order_x", 5}},
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

/// How strongly the outermost operation of a text binds.
enum Binding { binding_sum, binding_product, binding_sign, binding_power, binding_atom };

struct Written {
    std::string text;
    Binding binding = binding_atom;
};

inline std::string enclosed(const Written& part, Binding at_least) {
    return part.binding >= at_least ? part.text : "(" + part.text + ")";
}

inline Written written(const Node& node, const Written& a, const Written& b) {
    const auto infix = [&](const char* sign, Binding left, Binding right, Binding binding) {
        return Written{enclosed(a, left) + sign + enclosed(b, right), binding};
    };
    switch (node.operation) {
        case Operation::add: return infix(" + ", binding_sum, binding_product, binding_sum);
        case Operation::subtract: return infix(" - ", binding_sum, binding_product, binding_sum);
        case Operation::multiply: return infix(" * ", binding_product, binding_sign, binding_product);
        case Operation::divide: return infix(" / ", binding_product, binding_sign, binding_product);
        case Operation::power: return infix("^", binding_atom, binding_sign, binding_power);
        case Operation::negate: return {"-" + enclosed(a, binding_sign), binding_sign};
        default: break;
    }
    for (const FunctionName& function : function_names)
        if (function.operation == node.operation)
            return {function.name + ("(" + a.text) + (is_binary(node) ? ", " + b.text : "") + ")", binding_atom};
    return {};
}

inline std::string name_of_slot(int slot) {
    for (const auto& [name, index] : test_vocabulary().variables)
        if (index == slot) return name;
    return {};
}

/// A text that parse_expression() reads back as the same expression; empty if it is too long for that.
inline std::string text_of(const Expression& expression) {
    constexpr std::size_t max_characters = 10000;  // that parse_expression() takes
    const Expression::Graph& graph = expression.graph();
    const Written none;
    std::vector<Written> parts;
    for (const Node& node : graph.nodes) {
        const auto part = [&](int i) -> const Written& { return i < 0 ? none : parts[static_cast<std::size_t>(i)]; };
        if (node.operation == Operation::number)
            parts.push_back({text("{}", node.value), std::signbit(node.value) ? binding_sign : binding_atom});
        else if (node.operation == Operation::slot) parts.push_back({name_of_slot(node.left), binding_atom});
        else parts.push_back(written(node, part(node.left), part(node.right)));
        if (parts.back().text.size() > max_characters) return {};
    }
    return parts.back().text;
}

}  // namespace drover
