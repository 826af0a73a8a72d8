// base/expression_text.cpp: expressions as text.
#include "base/expression_graph.hpp"

namespace drover {

namespace {
/// How strongly the outermost operation of a text binds.
enum Binding { binding_sum, binding_product, binding_sign, binding_power, binding_atom };

struct Written {
    std::string text;
    Binding binding = binding_atom;
};

std::string enclosed(const Written& part, Binding at_least) {
    return part.binding >= at_least ? part.text : "(" + part.text + ")";
}

Written written(const Node& node, const Written& a, const Written& b) {
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
}  // namespace

std::string text_of(const Expression& expression) {
    constexpr std::size_t max_characters = 10000;  // that parse_expression() takes
    const Expression::Graph& graph = expression.graph();
    const Written none;
    std::vector<Written> parts;
    for (const Node& node : graph.nodes) {
        const auto part = [&](int i) -> const Written& { return i < 0 ? none : parts[static_cast<std::size_t>(i)]; };
        if (node.operation == Operation::number)
            parts.push_back({text("{}", node.value), std::signbit(node.value) ? binding_sign : binding_atom});
        else if (node.operation == Operation::slot) parts.push_back({graph.names.at(node.left), binding_atom});
        else parts.push_back(written(node, part(node.left), part(node.right)));
        require(parts.back().text.size() <= max_characters, {},
                "the expression has more than {} characters when it is written out; expected a shorter one",
                max_characters);
    }
    return parts.back().text;
}

}  // namespace drover
