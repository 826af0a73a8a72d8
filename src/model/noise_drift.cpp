// model/noise_drift.cpp: the change of noise along itself, and its mean.
#include "model/noise_drift.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/steppers/kept_modes.hpp"

namespace drover::model {

bool NoiseDrift::is_noise(const LinearForm& form) const {
    return std::ranges::any_of(form, [this](const auto& entry) { return entry.first.component >= c_.components; });
}

void NoiseDrift::add(const Summand& summand, double mass) {
    const auto check = [&](bool holds, const std::string& what, const char* expected) {
        require(holds, summand.summary.where,
                "the noise \"{}\" is in the sense of Stratonovich, and {}; expected {}, or calculus = \"ito\"",
                summand.summary.text, what, expected);
    };
    const std::size_t index = summand.summary.field;
    const Field& field = c_.model.fields[index];
    check(!field.solenoidal, field.symbol + " is solenoidal", "noise of other fields");
    check(!std::isnan(mass) || summand.is_acceleration, "is divided by a mass that varies",
          "the mass as its first factor");
    for (std::size_t k = 0; k < summand.value.components.size(); ++k) {
        Component rate = summand.value.components[k];
        if (k < summand.noise.size()) rate.linear = summand.noise[k];
        for (const auto& [order, node] : rate.rest)
            for (const int slot : algebra_.slots_read(node))
                for (const auto& [derivative, coefficient] : algebra_.form_of(slot))
                    check(derivative.component >= c_.components || !c_.in_balance(derivative.component),
                          "depends on a field in balance", "functions of fields with a rate");
        Component& total = rates_[c_.first_component[index] + static_cast<int>(k)];
        total = algebra_.sum(total, rate, summand.is_acceleration ? 1.0 : 1.0 / mass);
    }
    std::string& text = texts_[index];
    const std::string& term = summand.summary.text;
    text += (text.empty() ? "drift of " : ", ") + term.substr(std::min(term.size(), term.find_first_not_of("+ ")));
}

/// <f g> of two linear forms of white noises at one point.
double NoiseDrift::covariance(const LinearForm& f, const LinearForm& g) const {
    double sum = 0.0;
    for (const auto& [one, of_one] : f)
        for (const auto& [other, of_other] : g) {
            const Order both = one.order + other.order;
            if (one.component != other.component || both.x % 2 != 0 || both.y % 2 != 0) continue;
            const int power = (both.x + both.y) / 2 + other.order.x + other.order.y;  // of -1: (i q)^one (-i q)^other
            sum += (power % 2 == 0 ? 1.0 : -1.0) * of_one * of_other * c_.model.noise_moment(both.x, both.y);
        }
    return sum;
}

/// What a linear form of fields changes by along the noise.
int NoiseDrift::change_of(int slot) {
    const LinearForm form = algebra_.form_of(slot);
    Component change;
    for (const auto& [derivative, coefficient] : form)
        if (const auto rate = rates_.find(derivative.component); rate != rates_.end())
            change = algebra_.sum(change, algebra_.derivative(rate->second, derivative.order), coefficient);
    return algebra_.at_points(change);
}

/// The mean of half of a function that is quadratic in the noise.
int NoiseDrift::mean_of(int square) {
    const auto slope = [this](int node, int slot) {
        return chain_rule(algebra_.graph, node,
                          [&](int other) { return algebra_.graph.number(other == slot ? 1.0 : 0.0); });
    };
    std::vector<int> noises;
    for (const int slot : algebra_.slots_read(square))
        if (is_noise(algebra_.form_of(slot))) noises.push_back(slot);
    int mean = algebra_.graph.number(0.0);
    for (const int one : noises)
        for (const int other : noises) {
            // Half of the mean, and half of it again: both orders of a pair are there.
            const double weight = 0.25 * covariance(algebra_.form_of(one), algebra_.form_of(other));
            if (weight == 0.0) continue;
            const int part = algebra_.graph.make(Operation::multiply, algebra_.graph.number(weight),
                                                 slope(slope(square, one), other));
            mean = algebra_.graph.make(Operation::add, mean, part);
        }
    return mean;
}

std::vector<Component> NoiseDrift::of(std::size_t field) {
    std::vector<Component> result;
    if (!texts_.contains(field)) return result;
    for (int k = 0; k < components(c_.model.fields[field]); ++k) {
        Component sum;
        const std::map<Order, int> rest = rates_.at(c_.first_component[field] + k).rest;
        for (const auto& [order, node] : rest) {
            const int square = algebra_.slope(node, [this](int slot) { return change_of(slot); });
            sum = algebra_.sum(sum, algebra_.derivative(algebra_.of_node(mean_of(square)), order));
        }
        result.push_back(std::move(sum));
    }
    return result;
}

double noise_moment(const numerics::Grid& grid, int kept_degree, int x, int y) {
    double sum = 0.0;
    const std::size_t width = numerics::columns(grid);
    numerics::for_kept_rows({grid, kept_degree}, [&](std::size_t first, std::size_t count) {
        for (std::size_t column = 0; column < count; ++column) {
            const numerics::Wavevector q = numerics::wavevector(grid, column, first / width);
            sum += (column == 0 ? 1.0 : 2.0) * std::pow(q.x, x) * std::pow(q.y, y);
        }
    });
    return sum / numerics::area(grid);
}

}  // namespace drover::model
