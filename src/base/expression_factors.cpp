// base/expression_factors.cpp: sums with like terms joined and common factors in front, for fewer operations.
#include "base/expression_graph.hpp"

namespace drover {

namespace {
/// coefficient * factors: nodes in ascending order.
struct Product {
    double coefficient = 1.0;
    std::vector<int> factors = {};
};
using Sum = std::vector<Product>;

constexpr int max_size = 2000;             // operations: larger expressions stay as they are
constexpr std::size_t max_products = 200;  // of a sum: in larger ones, common factors stay where they are
constexpr std::size_t max_joining = 20;    // products of a sum that joins several others

/// Remakes the nodes of `from_` in `graph_`.
class Factoring {
public:
    explicit Factoring(const GraphBuilder& from, const std::vector<int>& roots) : from_(from), uses_(from.uses(roots)) {
        for (int node = 0; node < from_.size(); ++node)
            if (from_[node].operation == Operation::divide && uses_[static_cast<std::size_t>(node)] > 0)
                ++quotients_[from_[node].right];
        for (int node = 0; node < from_.size(); ++node)
            made_.push_back(uses_[static_cast<std::size_t>(node)] > 0 ? make(node) : -1);
    }
    Expression result(int root) const { return graph_.expression(at(root)); }

private:
    bool is_used_once(int node) const { return uses_[static_cast<std::size_t>(node)] == 1; }
    int at(int node) const { return node < 0 ? -1 : made_[static_cast<std::size_t>(node)]; }

    int make(int index) {
        const Node& node = from_[index];
        switch (node.operation) {
            case Operation::number: return graph_.number(node.value);
            case Operation::slot: return graph_.slot(node.left);
            case Operation::add:
            case Operation::subtract:
            case Operation::negate: {
                const Sum sum = joined(sum_of(index));
                const int result = sum_node(sum);
                const bool has_constant = !sum.empty() && sum[0].factors.empty();
                if (has_constant && sum.size() > 1 && sum.size() <= max_joining) with_constant_.emplace(result, sum);
                return result;
            }
            case Operation::multiply:
            case Operation::divide: {
                const Product product = product_of(index);
                if (product.coefficient != 0.0 && std::isfinite(product.coefficient)) return signed_node(product);
                break;
            }
            default: break;
        }
        return graph_.make(node.operation, at(node.left), at(node.right));
    }

    /// Products that add up to a node.  A sum within it joins it if nothing else needs that sum, or if it has a
    /// constant, which may then cancel.
    Sum sum_of(int root) {
        struct Waiting {
            int node;
            double coefficient;
        };
        Sum sum;
        std::vector<Waiting> waiting{{root, 1.0}};
        while (!waiting.empty()) {
            const auto [index, coefficient] = waiting.back();
            waiting.pop_back();
            const Node& node = from_[index];
            const bool is_sum = node.operation == Operation::add || node.operation == Operation::subtract;
            if (node.operation == Operation::negate) waiting.push_back({node.left, -coefficient});
            else if (is_sum && (index == root || (is_used_once(index) && std::abs(coefficient) == 1.0))) {
                waiting.push_back({node.right, node.operation == Operation::add ? coefficient : -coefficient});
                waiting.push_back({node.left, coefficient});
            } else if (node.operation == Operation::multiply && from_.is_number(node.left)) {
                waiting.push_back({node.right, coefficient * from_[node.left].value});
            } else {
                Product product = product_of(index);
                if (product.coefficient == 0.0 || !std::isfinite(product.coefficient)) product = {1.0, {at(index)}};
                product.coefficient *= coefficient;
                append(product, sum);
            }
        }
        return sum;
    }

    /// A product of one sum with a constant is the products of that sum.
    void append(const Product& product, Sum& sum) const {
        const auto found = product.factors.size() == 1 ? with_constant_.find(product.factors[0]) : with_constant_.end();
        if (found == with_constant_.end() || graph_.size() > GraphBuilder::max_nodes / 2) return sum.push_back(product);
        for (const Product& part : found->second) {
            sum.push_back(part);
            sum.back().coefficient *= product.coefficient;
        }
    }

    Product product_of(int root) {
        Product product;
        std::vector<int> waiting{root};
        while (!waiting.empty()) {
            const int index = waiting.back();
            waiting.pop_back();
            const Node& node = from_[index];
            if (node.operation == Operation::number) product.coefficient *= node.value;
            else if (node.operation == Operation::multiply) {
                waiting.push_back(node.right);
                waiting.push_back(node.left);
            } else if (node.operation == Operation::negate) {
                product.coefficient = -product.coefficient;
                waiting.push_back(node.left);
            } else if (node.operation == Operation::divide && quotients_[node.right] > 1) {
                // A divisor of several quotients is inverted once.
                const Product divisor = product_of(node.right);
                product.coefficient /= divisor.coefficient;
                const int inverse =
                    graph_.make(Operation::divide, graph_.number(1.0), product_node(1.0, divisor.factors));
                product.factors.push_back(inverse);
                waiting.push_back(node.left);
            } else product.factors.push_back(node_of(index));
        }
        std::ranges::sort(product.factors);
        return product;
    }
    /// Of a node that is made, or that is being made.
    int node_of(int index) {
        const Node& node = from_[index];
        return made_.size() > static_cast<std::size_t>(index)
                   ? at(index)
                   : graph_.make(node.operation, at(node.left), at(node.right));
    }

    /// Equal products as one; a constant first.  What remains of coefficients that cancel is rounding.
    static Sum joined(const Sum& sum) {
        std::map<std::vector<int>, std::size_t> place;
        Sum result;
        std::vector<double> sizes;
        for (const Product& product : sum) {
            const auto [found, is_new] = place.emplace(product.factors, result.size());
            if (is_new) {
                result.push_back({0.0, product.factors});
                sizes.push_back(0.0);
            }
            result[found->second].coefficient += product.coefficient;
            sizes[found->second] += std::abs(product.coefficient);
        }
        constexpr double rounding = 1e-15;
        for (std::size_t i = 0; i < result.size(); ++i)
            if (std::abs(result[i].coefficient) <= rounding * sizes[i]) result[i].coefficient = 0.0;
        std::erase_if(result, [](const Product& product) { return product.coefficient == 0.0; });
        std::stable_partition(result.begin(), result.end(), [](const Product& p) { return p.factors.empty(); });
        return result;
    }

    /// The factor that most products have, the first one of several; -1 if no two have one.
    static int common_factor(const Sum& sum) {
        if (sum.size() > max_products) return -1;
        std::map<int, int> counts;
        int best = -1;
        for (const Product& product : sum)
            for (std::size_t i = 0; i < product.factors.size(); ++i)
                if (i == 0 || product.factors[i] != product.factors[i - 1]) ++counts[product.factors[i]];
        for (const Product& product : sum)
            for (const int factor : product.factors)
                if (counts[factor] > (best < 0 ? 1 : counts[best])) best = factor;
        return best;
    }

    int sum_node(Sum sum) {
        for (int factor = common_factor(sum); factor >= 0; factor = common_factor(sum)) {
            Sum others, cofactors;
            for (Product& product : sum) {
                const auto found = std::ranges::find(product.factors, factor);
                if (found == product.factors.end()) {
                    others.push_back(std::move(product));
                    continue;
                }
                product.factors.erase(found);
                append(product, cofactors);
            }
            const int cofactor = sum_node(joined(cofactors));
            if (graph_.is_number(cofactor)) {
                if (!graph_.is_number(cofactor, 0.0)) others.push_back({graph_[cofactor].value, {factor}});
            } else others.push_back({1.0, {std::min(factor, cofactor), std::max(factor, cofactor)}});
            sum = joined(others);
        }
        return added(sum);
    }

    /// The sum as it is, a positive product first.
    int added(Sum sum) {
        const bool is_negative =
            std::ranges::none_of(sum, [](const Product& p) { return p.coefficient > 0.0 || p.factors.empty(); });
        for (Product& product : sum)
            if (is_negative) product.coefficient = -product.coefficient;
        std::stable_partition(sum.begin(), sum.end(),
                              [](const Product& p) { return p.coefficient > 0.0 || p.factors.empty(); });
        int result = graph_.number(0.0);
        for (const Product& product : sum) {
            const bool is_subtracted = product.coefficient < 0.0 && !product.factors.empty();
            const int node = product_node(is_subtracted ? -product.coefficient : product.coefficient, product.factors);
            result = graph_.make(is_subtracted ? Operation::subtract : Operation::add, result, node);
        }
        return is_negative && !sum.empty() ? graph_.make(Operation::negate, result) : result;
    }

    int signed_node(const Product& product) {
        if (product.coefficient > 0.0) return product_node(product.coefficient, product.factors);
        return graph_.make(Operation::negate, product_node(-product.coefficient, product.factors));
    }
    /// The coefficient joins the last factor: components of a vector have the earlier ones apart, and share that one.
    int product_node(double coefficient, const std::vector<int>& factors) {
        if (factors.empty()) return graph_.number(coefficient);
        int result = graph_.make(Operation::multiply, graph_.number(coefficient), factors.back());
        for (auto factor = factors.rbegin() + 1; factor != factors.rend(); ++factor)
            result = graph_.make(Operation::multiply, *factor, result);
        return result;
    }

    const GraphBuilder& from_;
    GraphBuilder graph_{Folding::lenient};
    std::vector<int> uses_, made_;
    std::map<int, int> quotients_;      ///< divisor -> quotients by it
    std::map<int, Sum> with_constant_;  ///< sums in graph_
};
}  // namespace

std::vector<Expression> factored(std::span<const Expression> expressions) {
    GraphBuilder graph(Folding::lenient);
    std::vector<int> roots;
    for (const Expression& expression : expressions) roots.push_back(graph.import(expression.graph()));
    std::vector<Expression> result(expressions.begin(), expressions.end());
    if (graph.size() > max_size) return result;
    const Factoring factoring(graph, roots);
    for (std::size_t k = 0; k < roots.size(); ++k) result[k] = factoring.result(roots[k]);
    return result;
}

}  // namespace drover
