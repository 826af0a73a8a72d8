// model/algebra.cpp: sums, products and derivatives of components.
#include "model/algebra.hpp"

#include <cmath>

namespace drover::model {

void Algebra::add(LinearForm& form, const Derivative& derivative, double coefficient) const {
    require(derivative.order.x + derivative.order.y <= max_order, graph.where,
            "a derivative of order {}; expected at most {}", derivative.order.x + derivative.order.y, max_order);
    const auto place = form.emplace(derivative, 0.0).first;
    place->second += coefficient;
    require(std::isfinite(place->second), graph.where,
            "the coefficient of a field is {}; expected a number below 1e308 in size", place->second);
    if (place->second == 0.0) form.erase(place);
}

std::string rank_text(const Rank& rank, Parity parity) {
    const std::string pseudo = parity == Parity::odd ? "pseudo" : "";
    if (rank.indices > 0) return text("a {}tensor of rank {}", pseudo, rank.indices + rank.spin);
    if (rank.spin == 0) return "a " + pseudo + "scalar";
    if (rank.spin == 1) return "a " + pseudo + "vector";
    return rank.spin == 2 ? "a " + pseudo + "nematic (spin 2)" : text("a {}field of spin {}", pseudo, rank.spin);
}

Component Algebra::constant(double value) {
    Component result;
    if (value != 0.0) result.rest[no_derivative] = graph.number(value);
    return result;
}

Component Algebra::of_node(int node) const {
    Component result;
    if (!graph.is_number(node, 0.0)) result.rest[no_derivative] = node;
    return result;
}

std::optional<double> Algebra::constant_of(const Component& a) const {
    if (!a.linear.empty() || a.rest.size() > 1) return {};
    if (a.rest.empty()) return 0.0;
    const auto& [order, node] = *a.rest.begin();
    if (order != no_derivative || !graph.is_number(node)) return {};
    return graph[node].value;
}

Component Algebra::sum(const Component& a, const Component& b, double factor) {
    if (std::abs(factor) != 1.0) return sum(a, scaled(b, factor));
    Component result = a;
    for (const auto& [derivative, coefficient] : b.linear) add(result.linear, derivative, factor * coefficient);
    for (const auto& [order, node] : b.rest) {
        const auto place = result.rest.emplace(order, graph.number(0.0)).first;
        place->second = graph.make(factor > 0.0 ? Operation::add : Operation::subtract, place->second, node);
        if (graph.is_number(place->second, 0.0)) result.rest.erase(place);
    }
    return result;
}

Component Algebra::scaled(const Component& a, double factor) {
    Component result;
    if (factor == 0.0) return result;
    require(std::isfinite(factor), graph.where,
            "a factor or a reciprocal of it is {}; expected a number below 1e308 in size", factor);
    const int number = graph.number(factor);
    for (const auto& [derivative, coefficient] : a.linear) add(result.linear, derivative, factor * coefficient);
    for (const auto& [order, node] : a.rest) result.rest.emplace(order, graph.make(Operation::multiply, number, node));
    return result;
}

Component Algebra::product(const Component& a, const Component& b) {
    if (const auto number = constant_of(a)) return scaled(b, *number);
    if (const auto number = constant_of(b)) return scaled(a, *number);
    const int left = at_points(a), right = at_points(b);
    return of_node(graph.make(Operation::multiply, left, right));
}

Component Algebra::derivative(const Component& a, const Order& order) {
    Component result;
    for (const auto& [derivative, coefficient] : a.linear)
        add(result.linear, {derivative.component, derivative.order + order}, coefficient);
    for (const auto& [inner, node] : a.rest) {
        if (reads_atoms(node)) {
            const Order all = inner + order;
            require(all.x + all.y <= max_order, graph.where, "a derivative of order {}; expected at most {}",
                    all.x + all.y, max_order);
            result.rest.emplace(all, node);
            continue;
        }
        // Given functions of the position need not be periodic: x is not.
        const int slope = differentiated(node, order);
        if (!graph.is_number(slope, 0.0)) result = sum(result, of_node(slope));
    }
    return result;
}

bool Algebra::reads_atoms(int node) const {
    const std::set<int> slots = slots_read(node);
    return !slots.empty() && *slots.rbegin() >= first_atom;
}

std::vector<int> Algebra::call(const std::shared_ptr<const GivenFunction>& function,
                               const std::vector<int>& arguments) {
    const auto is_same = [&](const FunctionCall& c) { return c.function == function && c.arguments == arguments; };
    auto found = std::ranges::find_if(calls_, is_same);
    if (found == calls_.end()) {
        calls_.push_back({function, arguments, slots()});
        found = calls_.end() - 1;
        atoms_.resize(static_cast<std::size_t>(found->end() - first_atom));
    }
    std::vector<int> nodes;
    for (int result = 0; result < function->results; ++result) nodes.push_back(graph.slot(found->value_slot(result)));
    return nodes;
}

std::vector<double> slopes_of(const GivenFunction& function, std::span<const double> arguments) {
    std::vector<double> slopes = function.slopes(arguments);
    const std::size_t expected = arguments.size() * static_cast<std::size_t>(function.results);
    require(slopes.size() == expected, {}, "a function of {} arguments with {} results gave {} slopes; expected {}",
            arguments.size(), function.results, slopes.size(), expected);
    return slopes;
}

int total_slope(GraphBuilder& graph, const std::vector<FunctionCall>& calls, int root,
                const std::function<int(int slot)>& slope_of_slot) {
    std::map<int, int> of_results;
    const auto slope_of = [&](int slot) {
        if (call_of(calls, slot) == nullptr) return slope_of_slot(slot);
        const auto found = of_results.find(slot);
        require(found != of_results.end(), graph.where,
                "a second derivative of a function that is no formula, such as a table of coefficients; expected a "
                "formula, or fewer derivatives (noise in the sense of Stratonovich needs one more)");
        return found->second;
    };
    for (const FunctionCall& call : calls) {  // the arguments of each are results of earlier ones
        std::vector<int> of_arguments;
        for (const int argument : call.arguments) of_arguments.push_back(chain_rule(graph, argument, slope_of));
        for (int result = 0; result < call.function->results; ++result) {
            int sum = graph.number(0.0);
            for (std::size_t a = 0; a < of_arguments.size(); ++a) {
                if (graph.is_number(of_arguments[a], 0.0)) continue;
                const int by_argument = graph.slot(call.slope_slot(result, static_cast<int>(a)));
                sum = graph.make(Operation::add, sum, graph.make(Operation::multiply, by_argument, of_arguments[a]));
            }
            of_results[call.value_slot(result)] = sum;
        }
    }
    return chain_rule(graph, root, slope_of);
}

std::set<int> Algebra::slots_read(int node) const {
    std::set<int> result;
    for (const int slot : slots_of(graph.expression(node))) {
        const FunctionCall* call = call_of(calls_, slot);
        if (call == nullptr) result.insert(slot);
        else
            for (const int argument : call->arguments) result.merge(slots_read(argument));
    }
    return result;
}

int Algebra::differentiated(int node, const Order& order) {
    for (int i = 0; i < order.x; ++i) node = total_derivative(node, d_dx);
    for (int i = 0; i < order.y; ++i) node = total_derivative(node, d_dy);
    return node;
}

int Algebra::at_points(const Component& a) {
    int result = a.linear.empty() ? graph.number(0.0) : atom(a.linear);
    for (const auto& [order, node] : a.rest) {
        const int slope = differentiated(node, order);
        result = graph.make(Operation::add, result, slope);
    }
    return result;
}

int Algebra::atom(const LinearForm& form) {
    if (form.empty()) return graph.number(0.0);
    const double scale = form.begin()->second;
    LinearForm normal;
    for (const auto& [derivative, coefficient] : form) normal.emplace(derivative, coefficient / scale);
    const auto [place, is_new] = slot_of_.emplace(normal, slots());
    if (is_new) atoms_.push_back(normal);
    const int slot = graph.slot(place->second);
    return scale == 1.0 ? slot : graph.make(Operation::multiply, graph.number(scale), slot);
}

int Algebra::total_derivative(int node, const Order& direction) {
    return slope(node, [&](int slot) {
        if (slot < first_atom) return graph.number(slot == (direction.x > 0 ? slot_x : slot_y) ? 1.0 : 0.0);
        const LinearForm form = form_of(slot);
        LinearForm slope;
        for (const auto& [derivative, coefficient] : form)
            add(slope, {derivative.component, derivative.order + direction}, coefficient);
        return atom(slope);
    });
}

}  // namespace drover::model
