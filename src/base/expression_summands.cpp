// base/expression_summands.cpp: expressions expanded into sums of products.
#include "base/expression_graph.hpp"

namespace drover {

namespace {
/// Powers of nodes that are not sums, products or natural powers: node -> exponent.
using Factors = std::map<int, double>;
/// Factors -> coefficient, in the order of the factors: equal products meet.
using Polynomial = std::map<Factors, double>;

class Expansion {
public:
    explicit Expansion(const SourceLocation& where) : graph_(Folding::simplified, where) {}

    std::vector<Expression> of(const Expression& expression) {
        const std::vector<int> here = graph_.import(expression.graph());
        const int root = here.back();
        std::vector<Polynomial> sums(static_cast<std::size_t>(root) + 1);
        const std::vector<bool> needed = needed_by(root);
        for (int node = 0; node <= root; ++node)
            if (needed[static_cast<std::size_t>(node)]) sums[static_cast<std::size_t>(node)] = sum_of(node, sums);
        std::vector<Expression> result;
        for (const auto& [factors, coefficient] : sums[static_cast<std::size_t>(root)])
            result.push_back(graph_.expression(product_of(factors, coefficient)));
        return result;
    }

private:
    static constexpr std::size_t max_summands = 1000, max_work = 1000000;
    static constexpr double max_expanded_power = 64.0;

    /// The nodes that are expanded on the way to the root: arguments of functions are not.
    std::vector<bool> needed_by(int root) const {
        std::vector<bool> needed(static_cast<std::size_t>(root) + 1, false);
        needed[static_cast<std::size_t>(root)] = true;
        for (int i = root; i >= 0; --i) {
            const Node& node = graph_[i];
            if (!needed[static_cast<std::size_t>(i)] || is_leaf(node) || node.operation > Operation::negate) continue;
            needed[static_cast<std::size_t>(node.left)] = true;
            if (is_binary(node) && node.operation != Operation::power)
                needed[static_cast<std::size_t>(node.right)] = true;
        }
        return needed;
    }

    Polynomial sum_of(int index, const std::vector<Polynomial>& sums) {
        const Node node = graph_[index];
        const auto at = [&](int i) -> const Polynomial& { return sums[static_cast<std::size_t>(i)]; };
        switch (node.operation) {
            case Operation::number: return node.value == 0.0 ? Polynomial{} : Polynomial{{Factors{}, node.value}};
            case Operation::add: return added(at(node.left), at(node.right), 1.0);
            case Operation::subtract: return added(at(node.left), at(node.right), -1.0);
            case Operation::negate: return added({}, at(node.left), -1.0);
            case Operation::multiply: return multiplied(at(node.left), at(node.right));
            case Operation::divide: return divided(at(node.left), at(node.right), node.right);
            case Operation::power: return powered(at(node.left), index);
            default: return {{{{index, 1.0}}, 1.0}};
        }
    }

    void add(Polynomial& sum, const Factors& factors, double coefficient) {
        require(++work_ <= max_work, graph_.where,
                "the expression takes too long to expand into a sum of products; "
                "expected fewer products of sums");
        const auto place = sum.emplace(factors, 0.0).first;
        place->second = checked(place->second + coefficient);
        if (place->second == 0.0) sum.erase(place);
        require(sum.size() <= max_summands, graph_.where,
                "the expression has more than {} products when its products of sums are expanded; expected fewer",
                max_summands);
    }
    Polynomial added(const Polynomial& a, const Polynomial& b, double sign) {
        Polynomial result = a;
        work_ += a.size();
        for (const auto& [factors, coefficient] : b) add(result, factors, sign * coefficient);
        return result;
    }
    Polynomial multiplied(const Polynomial& a, const Polynomial& b) {
        Polynomial result;
        for (const auto& [factors_a, coefficient_a] : a)
            for (const auto& [factors_b, coefficient_b] : b) {
                Factors factors = factors_a;
                work_ += factors_a.size() + factors_b.size();
                for (const auto& [node, exponent] : factors_b) multiply(factors, node, exponent);
                add(result, factors, coefficient_a * coefficient_b);
            }
        return result;
    }
    static void multiply(Factors& factors, int node, double exponent) {
        const auto place = factors.emplace(node, 0.0).first;
        place->second += exponent;
        if (place->second == 0.0) factors.erase(place);
    }
    Polynomial divided(const Polynomial& a, const Polynomial& b, int divisor) {
        if (b.size() != 1) return multiplied(a, {{{{divisor, -1.0}}, 1.0}});  // a sum stays one factor
        const auto& [factors, coefficient] = *b.begin();
        return multiplied(a, {{raised(factors, -1.0), 1.0 / coefficient}});
    }
    Factors raised(Factors factors, double exponent) const {
        for (auto& [node, power] : factors) power = checked(power * exponent);
        return factors;
    }
    Polynomial powered(const Polynomial& base, int index) {
        const Node exponent = graph_[graph_[index].right];
        const double n = exponent.value;
        if (exponent.operation != Operation::number || n != std::floor(n)) return {{{{index, 1.0}}, 1.0}};
        if (base.size() == 1) return {{raised(base.begin()->first, n), checked(std::pow(base.begin()->second, n))}};
        if (n < 0.0) return {{{{graph_[index].left, n}}, 1.0}};
        require(n <= max_expanded_power, graph_.where,
                "the expression has a sum to the power {}; expected at most {} to expand it", n, max_expanded_power);
        Polynomial result = base;
        for (int i = 1; i < static_cast<int>(n); ++i) result = multiplied(result, base);
        return result;
    }
    double checked(double number) const {
        require(std::isfinite(number), graph_.where,
                "the expression has a coefficient or exponent of {} when it is expanded; expected a finite number",
                number);
        return number;
    }

    int product_of(const Factors& factors, double coefficient) {
        int above = graph_.number(coefficient), below = graph_.number(1.0);
        for (const auto& [node, exponent] : factors) {
            const int power = graph_.make(Operation::power, node, graph_.number(std::abs(exponent)));
            int& side = exponent > 0.0 ? above : below;
            side = graph_.make(Operation::multiply, side, power);
        }
        return graph_.make(Operation::divide, above, below);
    }

    GraphBuilder graph_;
    std::size_t work_ = 0;
};
}  // namespace

std::vector<Expression> summands(const Expression& expression, const SourceLocation& where) {
    return Expansion(where).of(expression);
}

}  // namespace drover
