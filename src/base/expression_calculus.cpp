// base/expression_calculus.cpp: values, derivatives and properties of expressions.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/expression_graph.hpp"

namespace drover {

namespace {
Expression simplified(const Expression& expression) {
    GraphBuilder graph(Folding::lenient);
    return graph.expression(graph.import(expression.graph()));
}

Expression combined(Operation operation, const Expression& a, const Expression& b) {
    GraphBuilder graph(Folding::simplified);
    const int left = graph.import(a.graph());
    return graph.expression(graph.make(operation, left, graph.import(b.graph())));
}

/// Derivatives of the nodes of a graph; `slopes` are those of the arguments.
class Differentiation {
public:
    explicit Differentiation(GraphBuilder& the_graph) : graph(the_graph) {}

    /// The derivative of a node that is not a leaf, from those of its arguments.
    int of(int node, int left_slope, int right_slope) {
        const Node n = graph[node];
        const int a = n.left, b = n.right;
        switch (n.operation) {
            case Operation::add:
            case Operation::subtract: return graph.make(n.operation, left_slope, right_slope);
            case Operation::negate: return graph.make(Operation::negate, left_slope);
            case Operation::multiply: return sum(product(left_slope, b), product(a, right_slope));
            case Operation::divide: return of_quotient(node, left_slope, right_slope);
            case Operation::power: return of_power(node, left_slope, right_slope);
            case Operation::atan2: {
                const int above = difference(product(b, left_slope), product(a, right_slope));
                return is_zero(above) ? above : quotient(above, sum(product(a, a), product(b, b)));
            }
            case Operation::max: return of_extremum(difference(a, b), left_slope, right_slope);
            case Operation::min: return of_extremum(difference(b, a), left_slope, right_slope);
            default: return is_zero(left_slope) ? left_slope : of_function(node, left_slope);
        }
    }

private:
    int sum(int a, int b) { return graph.make(Operation::add, a, b); }
    int difference(int a, int b) { return graph.make(Operation::subtract, a, b); }
    int product(int a, int b) { return graph.make(Operation::multiply, a, b); }
    int quotient(int a, int b) { return graph.make(Operation::divide, a, b); }
    int function(Operation operation, int a) { return graph.make(operation, a); }
    bool is_zero(int node) const { return graph.is_number(node, 0.0); }

    int of_quotient(int node, int left_slope, int right_slope) {
        const int b = graph[node].right;
        const int first = is_zero(left_slope) ? left_slope : quotient(left_slope, b);
        return is_zero(right_slope) ? first : difference(first, quotient(product(node, right_slope), b));
    }
    int of_power(int node, int left_slope, int right_slope) {
        const int a = graph[node].left, b = graph[node].right;
        int result = graph.number(0.0);
        if (!is_zero(left_slope)) {
            const int exponent = difference(b, graph.number(1.0));
            result = product(product(b, graph.make(Operation::power, a, exponent)), left_slope);
        }
        if (is_zero(right_slope)) return result;
        return sum(result, product(product(node, function(Operation::log, a)), right_slope));
    }
    int of_extremum(int lead, int left_slope, int right_slope) {
        if (left_slope == right_slope) return left_slope;
        const int is_left = function(Operation::step, lead);
        return sum(product(is_left, left_slope), product(difference(graph.number(1.0), is_left), right_slope));
    }
    int of_function(int node, int slope) {
        const int a = graph[node].left, one = graph.number(1.0);
        switch (graph[node].operation) {
            case Operation::abs: return product(function(Operation::sign, a), slope);
            case Operation::atan: return quotient(slope, sum(one, product(a, a)));
            case Operation::cos: return function(Operation::negate, product(function(Operation::sin, a), slope));
            case Operation::cosh: return product(function(Operation::sinh, a), slope);
            case Operation::exp: return product(node, slope);
            case Operation::log: return quotient(slope, a);
            case Operation::sin: return product(function(Operation::cos, a), slope);
            case Operation::sinh: return product(function(Operation::cosh, a), slope);
            case Operation::sqrt: return quotient(slope, product(graph.number(2.0), node));
            case Operation::tan: return product(sum(one, product(node, node)), slope);
            case Operation::tanh: return product(difference(one, product(node, node)), slope);
            default: return graph.number(0.0);  // sign, step
        }
    }

    GraphBuilder& graph;
};

/// function: the value of a node from those of its arguments.
template <class Function>
double evaluated(const Expression& expression, std::span<const double> slots, Function function) {
    const std::vector<Node>& nodes = expression.graph().nodes;
    std::array<double, 256> few;
    std::vector<double> many(nodes.size() > few.size() ? nodes.size() : 0);
    double* const values = many.empty() ? few.data() : many.data();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        if (node.operation == Operation::number) values[i] = node.value;
        else if (node.operation == Operation::slot) values[i] = slots[static_cast<std::size_t>(node.left)];
        else values[i] = function(node.operation, values[node.left], is_binary(node) ? values[node.right] : 0.0);
    }
    return values[nodes.size() - 1];
}
}  // namespace

Expression::Expression(double constant) {
    GraphBuilder graph(Folding::exact);
    *this = graph.expression(graph.number(constant));
}

Expression operator+(const Expression& a, const Expression& b) { return combined(Operation::add, a, b); }
Expression operator-(const Expression& a, const Expression& b) { return combined(Operation::subtract, a, b); }
Expression operator*(const Expression& a, const Expression& b) { return combined(Operation::multiply, a, b); }

double evaluate(const Expression& expression, std::span<const double> slots) {
    return evaluated(expression, slots, apply);
}

bool jumps_at(const Expression& expression, std::span<const double> slots) {
    if (!expression.graph().has_jumps) return false;
    const auto beside = [&](double side) {
        return evaluated(expression, slots, [side](Operation operation, double a, double b) {
            return apply(operation, is_jump(operation) && a == 0.0 ? side : a, b);
        });
    };
    const double above = beside(1.0), below = beside(-1.0);
    constexpr double rounding = 1e-12;
    return std::abs(above - below) > rounding * (std::abs(above) + std::abs(below));
}

int chain_rule(GraphBuilder& graph, int root, const std::function<int(int slot)>& slope_of_slot) {
    Differentiation differentiation(graph);
    const auto end = static_cast<std::size_t>(root) + 1;
    std::vector<bool> needed(end, false);
    needed[end - 1] = true;
    for (std::size_t node = end; node-- > 0;) {
        const Node& n = graph[static_cast<int>(node)];
        if (!needed[node] || is_leaf(n)) continue;
        needed[static_cast<std::size_t>(n.left)] = true;
        if (is_binary(n)) needed[static_cast<std::size_t>(n.right)] = true;
    }
    std::vector<int> slopes(end, -1);
    for (std::size_t node = 0; node < end; ++node) {
        if (!needed[node]) continue;
        const Node n = graph[static_cast<int>(node)];
        const auto slope_of = [&](int argument) {
            return argument < 0 ? -1 : slopes[static_cast<std::size_t>(argument)];
        };
        slopes[node] = n.operation == Operation::number ? graph.number(0.0)
                       : n.operation == Operation::slot
                           ? slope_of_slot(n.left)
                           : differentiation.of(static_cast<int>(node), slope_of(n.left), slope_of(n.right));
    }
    return slopes[end - 1];
}

Expression derivative(const Expression& expression, int slot, const SourceLocation& where) {
    GraphBuilder graph(Folding::simplified, where);
    const int root = graph.import(expression.graph());
    return graph.expression(
        chain_rule(graph, root, [&](int other) { return graph.number(other == slot ? 1.0 : 0.0); }));
}

Expression bind(const Expression& expression, int slot, double value, const SourceLocation& where) {
    require(std::isfinite(value), where, "the value {} is put into an expression; expected a finite number", value);
    GraphBuilder graph(Folding::simplified, where);
    const auto node_of = [&](int other) { return other == slot ? graph.number(value) : graph.slot(other); };
    return graph.expression(graph.import(expression.graph(), node_of));
}

std::set<int> slots_of(const Expression& expression) {
    std::set<int> slots;
    for (const Node& node : expression.graph().nodes)
        if (node.operation == Operation::slot) slots.insert(node.left);
    return slots;
}

bool is_zero(const Expression& expression) { return constant_value(expression) == 0.0; }

std::optional<double> constant_value(const Expression& expression) {
    const Expression simple = simplified(expression);
    const Node& root = simple.graph().nodes.back();
    return root.operation == Operation::number ? std::optional(root.value) : std::nullopt;
}

}  // namespace drover
