// base/expression_graph.hpp: the operations of expressions and the graphs that hold them.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <unordered_map>

#include "drover/base/expression.hpp"

namespace drover {

enum class Operation : std::uint8_t {
    number,
    slot,
    add,
    subtract,
    multiply,
    divide,
    power,
    negate,
    abs,
    atan,
    atan2,
    cos,
    cosh,
    exp,
    log,
    max,
    min,
    sign,
    sin,
    sinh,
    sqrt,
    step,
    tan,
    tanh
};

struct FunctionName {
    const char* name;
    Operation operation;
    int arguments;
};
inline constexpr std::array function_names{
    FunctionName{"abs", Operation::abs, 1},     FunctionName{"atan", Operation::atan, 1},
    FunctionName{"atan2", Operation::atan2, 2}, FunctionName{"cos", Operation::cos, 1},
    FunctionName{"cosh", Operation::cosh, 1},   FunctionName{"exp", Operation::exp, 1},
    FunctionName{"log", Operation::log, 1},     FunctionName{"max", Operation::max, 2},
    FunctionName{"min", Operation::min, 2},     FunctionName{"pow", Operation::power, 2},
    FunctionName{"sign", Operation::sign, 1},   FunctionName{"sin", Operation::sin, 1},
    FunctionName{"sinh", Operation::sinh, 1},   FunctionName{"sqrt", Operation::sqrt, 1},
    FunctionName{"step", Operation::step, 1},   FunctionName{"tan", Operation::tan, 1},
    FunctionName{"tanh", Operation::tanh, 1}};

/// nullptr if there is no such function.
const FunctionName* find_function(const std::string& name);
/// The number of its arguments; 0 if there is no such function.
int function_arguments(const std::string& name);

/// The value of one operation; b is ignored by those of one argument.
inline double apply(Operation operation, double a, double b) {
    switch (operation) {
        case Operation::add: return a + b;
        case Operation::subtract: return a - b;
        case Operation::multiply: return a * b;
        case Operation::divide: return a / b;
        case Operation::power: return std::pow(a, b);
        case Operation::negate: return -a;
        case Operation::abs: return std::abs(a);
        case Operation::atan: return std::atan(a);
        case Operation::atan2: return std::atan2(a, b);
        case Operation::cos: return std::cos(a);
        case Operation::cosh: return std::cosh(a);
        case Operation::exp: return std::exp(a);
        case Operation::log: return std::log(a);
        case Operation::max: return std::max(a, b);
        case Operation::min: return std::min(a, b);
        case Operation::sign: return (a > 0.0 ? 1.0 : 0.0) - (a < 0.0 ? 1.0 : 0.0);
        case Operation::sin: return std::sin(a);
        case Operation::sinh: return std::sinh(a);
        case Operation::sqrt: return std::sqrt(a);
        case Operation::step: return a > 0.0 ? 1.0 : 0.0;
        case Operation::tan: return std::tan(a);
        case Operation::tanh: return std::tanh(a);
        case Operation::number:
        case Operation::slot: break;
    }
    return a;
}

/// One operation on earlier nodes of the same graph.
struct Node {
    Operation operation = Operation::number;
    int left = -1, right = -1;  ///< of a slot, left is the slot
    double value = 0.0;         ///< of a number
    bool operator==(const Node&) const = default;
};

/// Whether right is a node: the operation has two arguments.
inline bool is_binary(const Node& node) { return node.right >= 0; }
inline bool is_leaf(const Node& node) {
    return node.operation == Operation::number || node.operation == Operation::slot;
}

inline bool is_jump(Operation operation) { return operation == Operation::sign || operation == Operation::step; }

/// Nodes, each after its arguments; the last one is the expression, and it needs all others.
struct Expression::Graph {
    std::vector<Node> nodes;
    bool has_jumps = false;  ///< has a sign or a step
};

/// How a builder treats operations on constants and trivial ones.
enum class Folding {
    exact,       ///< constants are folded, and nothing else: the same operations as in the text
    simplified,  ///< 0 + f, 1 f, 0 f, f - f, signs and constant factors as well
    lenient      ///< simplified, but operations on constants stay when they give an infinite or undefined result
};

/// Builds a graph in which each subexpression occurs once.
class GraphBuilder {
public:
    explicit GraphBuilder(Folding folding, const SourceLocation& location = {}) : where(location), folding_(folding) {}

    int number(double value) { return intern({.operation = Operation::number, .value = value}); }
    int slot(int index) { return intern({.operation = Operation::slot, .left = index}); }
    /// The node of an operation on nodes.  Throws an input Error at `where` for more than max_nodes nodes and, unless
    /// lenient, for an infinite or undefined constant.
    int make(Operation operation, int left, int right = -1);
    /// The root of a graph here, made anew: simplified if this builder simplifies.  slot_node(slot) and
    /// make_node(operation, left, right) stand in for slot and make.
    template <class SlotNode, class MakeNode>
    int import(const Expression::Graph& graph, SlotNode slot_node, MakeNode make_node) {
        std::vector<int> here;
        here.reserve(graph.nodes.size());
        for (const Node& node : graph.nodes) {
            const auto at = [&](int there) { return there < 0 ? -1 : here[static_cast<std::size_t>(there)]; };
            if (node.operation == Operation::number) here.push_back(number(node.value));
            else if (node.operation == Operation::slot) here.push_back(slot_node(node.left));
            else here.push_back(make_node(node.operation, at(node.left), at(node.right)));
        }
        return here.back();
    }
    template <class SlotNode>
    int import(const Expression::Graph& graph, SlotNode slot_node) {
        return import(graph, slot_node, [this](Operation o, int left, int right) { return make(o, left, right); });
    }
    int import(const Expression::Graph& graph) {
        return import(graph, [this](int index) { return slot(index); });
    }

    const Node& operator[](int node) const { return nodes_[static_cast<std::size_t>(node)]; }
    bool is_number(int node) const { return (*this)[node].operation == Operation::number; }
    bool is_number(int node, double value) const { return is_number(node) && (*this)[node].value == value; }
    int size() const { return static_cast<int>(nodes_.size()); }
    /// The expression of a node, with the nodes that it needs.
    Expression expression(int node) const;
    /// How often each node is an argument of those that these roots need, or a root.
    std::vector<int> uses(const std::vector<int>& roots) const;

    static constexpr int max_nodes = 20000;
    SourceLocation where;  ///< for errors

private:
    struct Hash {
        std::size_t operator()(const Node& node) const;
    };
    int intern(const Node& node);
    int folded(Operation operation, int left, int right);
    int simplified(Operation operation, int left, int right);
    int simplified_sum(int left, int right);
    int simplified_difference(int left, int right);
    int simplified_product(int left, int right);
    int simplified_quotient(int left, int right);
    int simplified_negative(int node);

    Folding folding_;
    std::vector<Node> nodes_;
    std::unordered_map<Node, int, Hash> index_;
};

/// The derivative of a node by the chain rule, from the derivative of each slot that it depends on.
int chain_rule(GraphBuilder& graph, int node, const std::function<int(int slot)>& slope_of_slot);

}  // namespace drover
