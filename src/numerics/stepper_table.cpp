// numerics/stepper_table.cpp: the methods: one row each, with its citation and order.
#include "drover/numerics/stepper_table.hpp"

#include <algorithm>

#include "drover/base/error.hpp"

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

const std::vector<StepperTable> tables{
    {"exponential-euler", 1, "Hochbruck & Ostermann, Acta Numerica 19, 209 (2010), eq. (2.8)", {{1, {{{1, 1}}}}}},
    {"etdrk2",
     2,
     "Cox & Matthews, J. Comput. Phys. 176, 430 (2002), eqs. (20)-(22)",
     {{1, {{{1, 1}}}}, {1, {{{1, 1}, {-1, 2}}, {{1, 2}}}}},
     {{{-1, 2}}, {{1, 2}}},
     "the same, eq. (20): exponential Euler is its first stage"},
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
}  // namespace

std::span<const StepperTable> stepper_tables() { return tables; }

const StepperTable& stepper_table(const std::string& name) {
    const auto found =
        std::find_if(tables.begin(), tables.end(), [&](const StepperTable& table) { return table.name == name; });
    if (found != tables.end()) return *found;
    std::vector<std::string> names;
    for (const StepperTable& table : tables) names.push_back(table.name);
    fail_input({}, "unknown stepper \"{}\"; expected one of {}", name, joined(names));
}

}  // namespace drover::numerics
