// physics/linear_theory.cpp: isotropic blocks of a model, and its rates and structure factors.
#include "physics/linear_theory.hpp"

#include <algorithm>

#include "numerics/steppers/kept_modes.hpp"
#include "physics/function_terms.hpp"

namespace drover::physics {

int kept_degree(const Equations& equations, const Dealiasing& dealiasing) {
    int most = 1;
    const FieldRow* pointwise = pointwise_balance(equations);
    const int balanced = pointwise == nullptr ? -1 : equations.component(pointwise->symbol);
    for (std::size_t n = 0; n < equations.terms().size(); ++n) {
        const model::TermSummary& term = equations.right_sides().terms()[n];
        // A field in balance is divided by its drag as it is, which needs no product.
        const model::Field& field = equations.right_sides().model().fields[term.field];
        if (presence(equations.model, field.symbol) == Presence::balance &&
            equations.terms()[n] == key_of_term(field.symbol, field.symbol))
            continue;
        // One that is a nonlinear function of the fields counts as two factors.
        const bool is_product = pointwise != nullptr && std::count(term.reads.begin(), term.reads.end(), balanced) > 0;
        most = std::max(most, term.degree + (is_product ? 1 : 0));
    }
    // 1/rho has no finite degree: its products count as quadratic, and outputs tell the tail of the spectrum.
    for (const FieldRow& field : equations.model.file->fields)
        for (const FieldRow* density : densities(*equations.model.file))
            if (presence(equations.model, field) == Presence::rate &&
                presence(equations.model, *density) == Presence::rate && is_in_mass(field, *density))
                most = std::max(most, 2);
    return numerics::kept_degree(most, dealiasing.rule);
}

numerics::System linear_system(const Equations& equations, const numerics::Grid& grid, const Densities& about,
                               const Dealiasing& dealiasing) {
    return equations.solver(about).linear_system(grid, kept_degree(equations, dealiasing));
}

numerics::System linear_system(const ModelValues& model, const numerics::Grid& grid, const Dealiasing& dealiasing) {
    return linear_system(Equations(model), grid, mean_densities(model), dealiasing);
}

namespace {
bool is_uniform(const Equations& equations, std::size_t term) {
    const SourceRow& source = equations.model.file->source;
    return !equations.right_sides().terms()[term].is_placed &&
           !(equations.terms()[term] == source.section && word(equations.model, source.section + ".kind") == "point");
}
}  // namespace

std::string nonuniform_term(const Equations& equations) {
    for (std::size_t n = 0; n < equations.terms().size(); ++n)
        if (!is_uniform(equations, n)) return equations.terms()[n];
    return "";
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::Dealiasing>>& schema<physics::Dealiasing>() {
    static const std::vector<Row<physics::Dealiasing>> rows{
        {"rule",
         &physics::Dealiasing::rule,
         "which modes are kept: exact: |k| < N/(d + 1) on each axis, d the degree of the highest product; "
         "two-thirds: "
         "|k| < N/3 for any d; none: |k| < N/2; outputs report the tail of the spectrum",
         "",
         any_number,
         {"exact", "two-thirds", "none"}},
    };
    return rows;
}

}  // namespace drover
