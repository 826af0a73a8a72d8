// numerics/steppers/combination.cpp: rates with a common matrix are summed before it is applied.
#include "numerics/steppers/combination.hpp"

#include <cmath>
#include <map>
#include <optional>

#include "base/mapped.hpp"

namespace drover::numerics {

namespace {
/// Terms by (order, at): sums with the same phi functions can be compared and subtracted.
using Weights = std::map<std::pair<int, double>, double>;

Weights weights_of(const std::vector<PhiTerm>& terms, double sign, Weights sum = {}) {
    for (const PhiTerm& term : terms) sum[{term.order, term.at}] += sign * term.weight;
    std::erase_if(sum, [](const auto& entry) { return std::abs(entry.second) < 1e-12; });
    return sum;
}

std::vector<PhiTerm> terms_of(const Weights& weights) {
    return mapped(weights, [](const auto& one) {
        return PhiTerm{.weight = one.second, .order = one.first.first, .at = one.first.second};
    });
}

/// The number f with b = f a, if it exists.  Weights are small fractions: their ratios are equal to rounding or differ
/// by much more.
std::optional<double> ratio(const Weights& a, const Weights& b) {
    if (a.size() != b.size() || a.empty()) return std::nullopt;
    const double factor = b.begin()->second / a.begin()->second;
    for (auto i = a.begin(), k = b.begin(); i != a.end(); ++i, ++k)
        if (i->first != k->first || std::abs(k->second - factor * i->second) > 1e-12 * std::abs(k->second))
            return std::nullopt;
    return factor;
}

/// One use of a matrix for all inputs whose weights are multiples of each other.
std::vector<MatrixUse> shared(const std::vector<Weights>& of_rates) {
    std::vector<MatrixUse> uses;
    std::vector<Weights> known;
    for (std::size_t j = 0; j < of_rates.size(); ++j) {
        if (of_rates[j].empty()) continue;
        const int input = static_cast<int>(j) + 1;
        bool found = false;
        for (std::size_t k = 0; k < known.size() && !found; ++k)
            if (const auto factor = ratio(known[k], of_rates[j])) {
                uses[k].inputs.push_back({.input = input, .weight = *factor});
                found = true;
            }
        if (found) continue;
        known.push_back(of_rates[j]);
        uses.push_back({.terms = terms_of(of_rates[j]), .inputs = {{.input = input}}});
    }
    return uses;
}

std::vector<Weights> all_weights(const std::vector<std::vector<PhiTerm>>& lists) {
    return mapped(lists, [](const auto& terms) { return weights_of(terms, 1.0); });
}
}  // namespace

std::vector<StagePlan> stage_plans(const StepperTable& table) {
    std::vector<StagePlan> plans;
    for (std::size_t s = 0; s < table.stages.size(); ++s) {
        const StepperStage& row = table.stages[s];
        StagePlan direct{.uses = shared(all_weights(row.terms))};
        direct.uses.insert(direct.uses.begin(), {.terms = {}, .inputs = {{.input = 0}}});
        if (s > 0 && table.stages[s - 1].c == row.c) {
            std::vector<Weights> differences = all_weights(row.terms);
            const auto& before = table.stages[s - 1].terms;
            for (std::size_t j = 0; j < before.size(); ++j)
                differences[j] = weights_of(before[j], -1.0, differences[j]);
            StagePlan relative{.from_previous = true, .uses = shared(differences)};
            if (relative.uses.size() < direct.uses.size()) {
                plans.push_back(std::move(relative));
                continue;
            }
        }
        plans.push_back(std::move(direct));
    }
    return plans;
}

StagePlan error_plan(const StepperTable& table) { return {.uses = shared(all_weights(table.error))}; }

}  // namespace drover::numerics
