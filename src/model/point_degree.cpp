// model/point_degree.cpp: degrees of the nodes of an expression.
#include <algorithm>
#include <cmath>

#include "model/compiled.hpp"

namespace drover::model {

PointDegree point_degree(const Expression& expression,
                         const std::function<std::optional<PointDegree>(int)>& of_result) {
    constexpr int max_degree = 1000;
    const std::vector<Node>& nodes = expression.graph().nodes;
    std::vector<PointDegree> degrees;
    for (const Node& node : nodes) {
        const auto of = [&](int index) {
            return index < 0 ? PointDegree{0, true} : degrees[static_cast<std::size_t>(index)];
        };
        const bool is_leaf_node = is_leaf(node);
        const PointDegree a = is_leaf_node ? PointDegree{0, true} : of(node.left),
                          b = is_leaf_node ? PointDegree{0, true} : of(node.right);
        PointDegree found{0, a.is_finite && b.is_finite};
        switch (node.operation) {
            case Operation::number: break;
            case Operation::slot:
                found.degree = node.left == slot_t ? 0 : 1;
                found.is_finite = node.left >= first_atom || node.left == slot_t;
                if (const auto result = of_result(node.left)) found = *result;
                break;
            case Operation::add:
            case Operation::subtract: found.degree = std::max(a.degree, b.degree); break;
            case Operation::negate: found.degree = a.degree; break;
            case Operation::multiply: found.degree = a.degree + b.degree; break;
            case Operation::divide:
                found.degree = a.degree + b.degree;
                found.is_finite = found.is_finite && b.degree == 0;
                break;
            case Operation::power: {
                const Node& exponent = nodes[static_cast<std::size_t>(node.right)];
                const bool is_natural = exponent.operation == Operation::number && exponent.value >= 0.0 &&
                                        exponent.value == std::floor(exponent.value);
                if (is_natural) found.degree = static_cast<int>(std::min(a.degree * exponent.value, 1.0 * max_degree));
                else if (a.degree + b.degree > 0) found = {std::max(2, a.degree), false};
                break;
            }
            default:
                if (a.degree + b.degree > 0) found = {std::max({2, a.degree, b.degree}), false};
                break;
        }
        found.degree = std::min(found.degree, max_degree);
        degrees.push_back(found);
    }
    return {std::max(1, degrees.back().degree), degrees.back().is_finite};
}

}  // namespace drover::model
