// physics/linear_theory.cpp: isotropic blocks of a model, and its rates and structure factors.
#include "drover/physics/linear_theory.hpp"

#include <algorithm>

#include "drover/numerics/kept_modes.hpp"

namespace drover::physics {

int kept_degree(const Equations& equations, const Dealiasing& dealiasing) {
    int most = 1;
    const bool pointwise = has_pointwise_velocity(equations);
    const int velocity = equations.component(FieldIndex::bead_velocity_x);
    for (std::size_t n = 0; n < equations.terms().size(); ++n) {
        const model::TermSummary& term = equations.forces().terms()[n];
        // A slaved velocity is divided by the drag as it is, which needs no product.
        if (equations.form.velocity == Velocity::slaved && equations.terms()[n] == "drag.coefficient") continue;
        // A velocity that is a nonlinear function of the fields counts as two factors.
        const bool is_product = pointwise && std::count(term.reads.begin(), term.reads.end(), velocity) > 0;
        most = std::max(most, term.degree + (is_product ? 1 : 0));
    }
    // 1/rho has no finite degree: its products count as quadratic, and outputs tell the tail of the spectrum.
    if (equations.form.velocity == Velocity::dynamic && equations.form.bead_density >= 0) most = std::max(most, 2);
    return numerics::kept_degree(most, dealiasing.rule);
}

numerics::System linear_system(const Equations& equations, const numerics::Grid& grid, const Reference& reference,
                               const Dealiasing& dealiasing) {
    return equations.solver(reference).linear_system(grid, kept_degree(equations, dealiasing));
}

numerics::System linear_system(const Model& model, const numerics::Grid& grid, const Dealiasing& dealiasing) {
    return linear_system(Equations(model), grid, reference(model.uniform), dealiasing);
}

namespace {
bool is_uniform(const Equations& equations, std::size_t term) {
    return !equations.forces().terms()[term].is_placed &&
           !(equations.terms()[term] == "force" && equations.model.force.kind == "point");
}
}  // namespace

std::string nonuniform_term(const Equations& equations) {
    for (std::size_t n = 0; n < equations.terms().size(); ++n)
        if (!is_uniform(equations, n)) return equations.terms()[n];
    return "";
}

std::vector<std::string> terms_beyond_propagator(const Equations& equations) {
    std::vector<std::string> names;
    for (std::size_t n = 0; n < equations.terms().size(); ++n)
        if (!is_uniform(equations, n) || equations.forces().terms()[n].is_explicit ||
            !equations.forces().is_isotropic(n))
            names.push_back(equations.terms()[n]);
    return names;
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::Dealiasing>>& schema<physics::Dealiasing>() {
    static const std::vector<Row<physics::Dealiasing>> rows{
        {.name = "rule",
         .member = &physics::Dealiasing::rule,
         .choices = {"exact", "two-thirds", "none"},
         .doc = "which modes are kept: exact: |k| < N/(d + 1) on each axis, d the degree of the highest product; "
                "two-thirds: "
                "|k| < N/3 for any d; none: |k| < N/2; outputs report the tail of the spectrum"}};
    return rows;
}

}  // namespace drover
