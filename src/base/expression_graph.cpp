// base/expression_graph.cpp: graphs without repeated subexpressions, and their simplification.
#include "base/expression_graph.hpp"

#include <bit>

namespace drover {

std::size_t GraphBuilder::Hash::operator()(const Node& node) const {
    std::uint64_t hash = static_cast<std::uint64_t>(node.operation);
    for (const std::uint64_t part :
         {static_cast<std::uint64_t>(node.left), static_cast<std::uint64_t>(node.right),
          std::bit_cast<std::uint64_t>(node.value == 0.0 ? 0.0 : node.value)}) {  // 0 == -0, so one hash
        hash = (hash ^ part) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 29;
    }
    return hash;
}

int GraphBuilder::intern(const Node& node) {
    if (node.operation == Operation::number && std::signbit(node.value) && node.value == 0.0) {
        // -0 equals 0 as a key, but is another number: it is not shared.
        nodes_.push_back(node);
        return size() - 1;
    }
    if (const auto found = index_.find(node); found != index_.end()) return found->second;
    if (node.operation == Operation::add || node.operation == Operation::multiply) {
        Node swapped = node;  // the same value to the last bit
        std::swap(swapped.left, swapped.right);
        if (const auto found = index_.find(swapped); found != index_.end()) return found->second;
    }
    require(size() < max_nodes, where, "the expression has more than {} operations; expected a shorter one", max_nodes);
    nodes_.push_back(node);
    index_.emplace(node, size() - 1);
    return size() - 1;
}

int GraphBuilder::make(Operation operation, int left, int right) {
    if (is_number(left) && (right < 0 || is_number(right))) return folded(operation, left, right);
    if (folding_ != Folding::exact) return simplified(operation, left, right);
    require(operation != Operation::divide || !is_number(right, 0.0), where,
            "the expression divides by zero; expected a divisor other than 0");
    return intern({.operation = operation, .left = left, .right = right});
}

int GraphBuilder::folded(Operation operation, int left, int right) {
    const double a = (*this)[left].value, b = right < 0 ? 0.0 : (*this)[right].value, value = apply(operation, a, b);
    if (std::isfinite(value)) return number(value);
    if (folding_ == Folding::lenient) return intern({.operation = operation, .left = left, .right = right});
    if (operation == Operation::divide && b == 0.0)
        fail_input(where, "the expression divides {} by zero; expected a divisor other than 0", a);
    std::string call;
    for (const FunctionName& function : function_names)
        if (function.operation == operation)
            call = right < 0 ? text("{}({})", function.name, a) : text("{}({}, {})", function.name, a, b);
    if (call.empty()) call = text("a sum, product or quotient of {} and {}", a, b);
    fail_input(where, "{} in the expression is {}; expected a finite constant", call, value);
}

int GraphBuilder::simplified(Operation operation, int left, int right) {
    switch (operation) {
        case Operation::add: return simplified_sum(left, right);
        case Operation::subtract: return simplified_difference(left, right);
        case Operation::multiply: return simplified_product(left, right);
        case Operation::divide: return simplified_quotient(left, right);
        case Operation::negate: return simplified_negative(left);
        case Operation::power:
            if (is_number(right, 0.0) || is_number(left, 1.0)) return number(1.0);
            if (is_number(right, 1.0)) return left;
            break;
        default: break;
    }
    return intern({.operation = operation, .left = left, .right = right});
}

int GraphBuilder::simplified_sum(int left, int right) {
    const Node a = (*this)[left], b = (*this)[right];
    if (is_number(left, 0.0)) return right;
    if (is_number(right, 0.0)) return left;
    if (b.operation == Operation::negate) return make(Operation::subtract, left, b.left);
    if (a.operation == Operation::negate) return make(Operation::subtract, right, a.left);
    if (left == right) return make(Operation::multiply, number(2.0), left);
    return intern({.operation = Operation::add, .left = left, .right = right});
}

int GraphBuilder::simplified_difference(int left, int right) {
    const Node b = (*this)[right];
    if (is_number(right, 0.0)) return left;
    if (is_number(left, 0.0)) return make(Operation::negate, right);
    if (left == right) return number(0.0);
    if (b.operation == Operation::negate) return make(Operation::add, left, b.left);
    return intern({.operation = Operation::subtract, .left = left, .right = right});
}

int GraphBuilder::simplified_product(int left, int right) {
    if (is_number(right)) std::swap(left, right);
    const Node a = (*this)[left], b = (*this)[right];
    if (is_number(left, 0.0)) return number(0.0);
    if (is_number(left, 1.0)) return right;
    if (is_number(left, -1.0)) return make(Operation::negate, right);
    if (is_number(left) && b.operation == Operation::multiply && is_number(b.left)) {
        const double factor = a.value * (*this)[b.left].value;
        if (std::isfinite(factor) && factor != 0.0) return make(Operation::multiply, number(factor), b.right);
    }
    if (is_number(left) && b.operation == Operation::negate) return make(Operation::multiply, number(-a.value), b.left);
    if (a.operation == Operation::negate) return make(Operation::negate, make(Operation::multiply, a.left, right));
    if (b.operation == Operation::negate) return make(Operation::negate, make(Operation::multiply, left, b.left));
    return intern({.operation = Operation::multiply, .left = left, .right = right});
}

int GraphBuilder::simplified_quotient(int left, int right) {
    const Node a = (*this)[left], b = (*this)[right];
    if (folding_ != Folding::lenient)
        require(!is_number(right, 0.0), where, "the expression divides by zero; expected a divisor other than 0");
    if (is_number(left, 0.0) && !is_number(right, 0.0)) return left;
    if (is_number(right, 1.0)) return left;
    if (is_number(right, -1.0)) return make(Operation::negate, left);
    if (a.operation == Operation::negate) return make(Operation::negate, make(Operation::divide, a.left, right));
    if (b.operation == Operation::negate) return make(Operation::negate, make(Operation::divide, left, b.left));
    return intern({.operation = Operation::divide, .left = left, .right = right});
}

int GraphBuilder::simplified_negative(int node) {
    const Node a = (*this)[node];
    if (a.operation == Operation::negate) return a.left;
    if (a.operation == Operation::subtract) return make(Operation::subtract, a.right, a.left);
    if (a.operation == Operation::multiply && is_number(a.left))
        return make(Operation::multiply, number(-(*this)[a.left].value), a.right);
    return intern({.operation = Operation::negate, .left = node});
}

std::vector<int> GraphBuilder::uses(const std::vector<int>& roots) const {
    std::vector<int> result(nodes_.size(), 0);
    for (const int root : roots) ++result[static_cast<std::size_t>(root)];
    for (std::size_t i = nodes_.size(); i-- > 0;) {
        if (result[i] == 0 || is_leaf(nodes_[i])) continue;
        ++result[static_cast<std::size_t>(nodes_[i].left)];
        if (is_binary(nodes_[i])) ++result[static_cast<std::size_t>(nodes_[i].right)];
    }
    return result;
}

Expression GraphBuilder::expression(int root) const {
    std::vector<int> place(static_cast<std::size_t>(root) + 1, -1);  // -1: not needed
    place[static_cast<std::size_t>(root)] = 0;
    for (int i = root; i >= 0; --i) {
        if (place[static_cast<std::size_t>(i)] < 0 || is_leaf((*this)[i])) continue;
        for (const int argument : {(*this)[i].left, (*this)[i].right})
            if (argument >= 0) place[static_cast<std::size_t>(argument)] = 0;
    }
    auto graph = std::make_shared<Expression::Graph>();
    for (int i = 0; i <= root; ++i) {
        if (place[static_cast<std::size_t>(i)] < 0) continue;
        place[static_cast<std::size_t>(i)] = static_cast<int>(graph->nodes.size());
        Node node = (*this)[i];
        if (node.operation != Operation::slot)
            for (int* argument : {&node.left, &node.right})
                if (*argument >= 0) *argument = place[static_cast<std::size_t>(*argument)];
        graph->nodes.push_back(node);
        graph->has_jumps = graph->has_jumps || is_jump(node.operation);
    }
    return Expression(std::move(graph));
}

}  // namespace drover
