// numerics/steppers/stepper_table.cpp: the methods: one row each, with its citation and order.
#include "drover/numerics/stepper_table.hpp"

#include <algorithm>
#include <cmath>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "drover/base/text.hpp"
#include "drover/numerics/block.hpp"

namespace drover::numerics {

namespace {
using Terms = std::vector<PhiTerm>;

// The weights of Cox & Matthews' fourth-order step, shared by its variants.
const std::vector<Terms> fourth_order_weights{{{1, 1}, {-3, 2}, {4, 3}},
                                              {{2, 2}, {-4, 3}},
                                              {{2, 2}, {-4, 3}},
                                              {{-1, 2}, {4, 3}}};

// The difference from a third-order state whose last weight is shared with the rate at the new state.
const std::vector<Terms> fourth_order_error{{}, {}, {}, {{-0.6, 2}, {2.4, 3}}, {{0.6, 2}, {-2.4, 3}}};
constexpr const char* fourth_order_error_citation =
    "Balac & Mahe, Comput. Phys. Commun. 184, 1211 (2013), their embedded pair 4(3) with exponential weights";

const std::vector<StepperTable> runge_kutta{
    {"exponential-euler", 1, "Hochbruck & Ostermann, Acta Numerica 19, 209 (2010), eq. (2.8)", {{1, {{{1, 1}}}}}},
    {"etdrk2",
     2,
     "Cox & Matthews, J. Comput. Phys. 176, 430 (2002), eqs. (20)-(22)",
     {{1, {{{1, 1}}}}, {1, {{{1, 1}, {-1, 2}}, {{1, 2}}}}},
     {{{-1, 2}}, {{1, 2}}},
     "the same, eq. (20): exponential Euler is its first stage"},
    {"etdrk3",
     3,
     "Cox & Matthews, J. Comput. Phys. 176, 430 (2002), eqs. (23)-(25)",
     {{0.5, {{{0.5, 1, 0.5}}}},
      {1, {{{-1, 1}}, {{2, 1}}}},
      {1, {{{1, 1}, {-3, 2}, {4, 3}}, {{4, 2}, {-8, 3}}, {{-1, 2}, {4, 3}}}}},
     {{{-1, 2}, {4, 3}}, {{2, 2}, {-8, 3}}, {{-1, 2}, {4, 3}}},
     "its first two rates with the weights phi_1 - 2 phi_2 and 2 phi_2: the step of second order with c_2 = 1/2 of "
     "Hochbruck & Ostermann, SIAM J. Numer. Anal. 43, 1069 (2005)"},
    {"etdrk4",
     4,
     "Cox & Matthews, J. Comput. Phys. 176, 430 (2002), eqs. (26)-(29)",
     {{0.5, {{{0.5, 1, 0.5}}}},
      {0.5, {{}, {{0.5, 1, 0.5}}}},
      {1, {{{1, 1, 1}, {-1, 1, 0.5}}, {}, {{1, 1, 0.5}}}},  // phi_1(z/2)(exp(z/2) - 1)/2 = phi_1(z) - phi_1(z/2)
      {1, fourth_order_weights}},
     fourth_order_error,
     fourth_order_error_citation},
    {"etdrk4-krogstad",
     4,
     "Krogstad, J. Comput. Phys. 203, 72 (2005), eq. (51)",
     {{0.5, {{{0.5, 1, 0.5}}}},
      {0.5, {{{0.5, 1, 0.5}, {-1, 2, 0.5}}, {{1, 2, 0.5}}}},
      {1, {{{1, 1}, {-2, 2}}, {}, {{2, 2}}}},
      {1, fourth_order_weights}},
     fourth_order_error,
     fourth_order_error_citation},
};

/// For each node j, the terms of the integral of exp((1 - s) dt L) l_j(s) dt over 0 < s < 1, where l_j is the
/// polynomial that is 1 at that node and 0 at the others [dt]: s^m contributes m! phi_(m+1).
std::vector<Terms> adams_weights(const std::vector<int>& nodes) {
    std::vector<Terms> result;
    for (const int node : nodes) {
        std::vector<double> product{1.0};  // integers: the coefficients of the product of (s - other), from s^0 on
        double divisor = 1.0;
        for (const int other : nodes) {
            if (other == node) continue;
            divisor *= node - other;
            product.insert(product.begin(), 0.0);
            for (std::size_t m = 0; m + 1 < product.size(); ++m) product[m] -= other * product[m + 1];
        }
        Terms terms;
        double factorial = 1.0;
        for (std::size_t m = 0; m < product.size(); ++m) {
            if (m > 0) factorial *= static_cast<double>(m);
            if (product[m] != 0.0)
                terms.push_back({.weight = factorial * product[m] / divisor, .order = static_cast<int>(m) + 1});
        }
        result.push_back(terms);
    }
    return result;
}

/// The nodes first, first - 1, ..., last.
std::vector<int> nodes_down(int first, int last) {
    std::vector<int> nodes;
    for (int node = first; node >= last; --node) nodes.push_back(node);
    return nodes;
}

/// Adds the Adams weights of these nodes, times `sign`, to lists of a method of `stages` stages.  Node 1 is the rate
/// numbered `at_end`.
void add_adams(const std::vector<int>& nodes, double sign, int stages, int at_end, std::vector<Terms>& lists) {
    const std::vector<Terms> weights = adams_weights(nodes);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const int rate = nodes[k] == 1 ? at_end : nodes[k] == 0 ? 0 : stages - nodes[k];
        if (lists.size() <= static_cast<std::size_t>(rate)) lists.resize(static_cast<std::size_t>(rate) + 1);
        for (PhiTerm term : weights[k]) {
            term.weight *= sign;
            lists[static_cast<std::size_t>(rate)].push_back(term);
        }
    }
}

constexpr const char* adams_citation =
    "Cox & Matthews, J. Comput. Phys. 176, 430 (2002), section 2; Hochbruck & Ostermann, BIT 51, 889 (2011)";

/// Predictor through the last order - 1 rates, evaluation, corrector through that at the new state as well; the
/// evaluation at the corrected state is the first of the next step.  The error: a corrector of the next order with the
/// rate at the corrected state.
StepperTable predictor_corrector(int order, int start_parts) {
    const int stages = 2, oldest = 2 - order;
    std::vector<Terms> predictor, corrector, error;
    add_adams(nodes_down(0, oldest), 1.0, stages, stages, predictor);
    add_adams(nodes_down(1, oldest), 1.0, stages, 1, corrector);
    add_adams(nodes_down(1, oldest), 1.0, stages, 1, error);
    add_adams(nodes_down(1, oldest - 1), -1.0, stages, stages, error);
    return {.name = text("etd-abm{}", order),
            .order = order,
            .citation = adams_citation,
            .stages = {{1.0, predictor}, {1.0, corrector}},
            .error = error,
            .error_citation = "the corrector of the next order",
            .history = -oldest,
            .start = "etdrk4-krogstad",
            .start_parts = start_parts};
}

const std::vector<StepperTable> tables = [] {
    std::vector<StepperTable> all = runge_kutta;
    for (const auto& [order, parts] : {std::pair{3, 1}, {4, 1}, {5, 2}, {6, 4}})
        all.push_back(predictor_corrector(order, parts));
    return all;
}();
}  // namespace

void check(const StepperTable& table) {
    const std::size_t stages = table.stages.size(), errors = table.error.size();
    require(stages > 0 && table.stages.back().c == 1.0, {},
            "stepper \"{}\": {} stages, the last at {} of the step; expected one or more, the last at 1", table.name,
            stages, stages > 0 ? table.stages.back().c : 0.0);
    const auto check_list = [&](const std::vector<Terms>& lists, bool is_length) {
        require(is_length, {}, "stepper \"{}\": {} lists of a stage or the error; expected one for each rate",
                table.name, lists.size());
        for (const Terms& terms : lists)
            for (const PhiTerm& term : terms)
                require(term.order >= 1 && term.order <= max_phi && std::isfinite(term.at), {},
                        "stepper \"{}\": phi_{} at {} of the step; expected orders of 1 to {}", table.name, term.order,
                        term.at, max_phi);
    };
    for (const StepperStage& stage : table.stages)
        require(std::isfinite(stage.c), {}, "stepper \"{}\": a stage at {} of the step", table.name, stage.c);
    for (std::size_t s = 0; s < stages; ++s)
        check_list(table.stages[s].terms,
                   table.history > 0 ? table.stages[s].terms.size() <= errors : table.stages[s].terms.size() == s + 1);
    check_list(table.error,
               table.history > 0 ? errors > stages : errors == 0 || errors == stages || errors == stages + 1);
}

std::span<const StepperTable> stepper_tables() { return tables; }

const StepperTable& stepper_table(const std::string& name) {
    const auto found = std::ranges::find(tables, name, &StepperTable::name);
    if (found != tables.end()) return *found;
    fail_input({}, "unknown stepper \"{}\"; expected one of {}", name, joined(mapped(tables, &StepperTable::name)));
}

}  // namespace drover::numerics
