// physics/linear_theory.cpp: isotropic blocks of a model, and its rates and structure factors.
#include "drover/physics/linear_theory.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>

#include "drover/numerics/kept_modes.hpp"
#include "drover/numerics/wavenumbers.hpp"

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

namespace {
/// Calls see(q, s) for the rates of both blocks.
template <class See>
void rates_at(const numerics::System& system, double q, See see) {
    const numerics::IsotropicBlocks blocks = system.linear(q);
    for (const auto* block : {&blocks.even, &blocks.odd})
        for (const numerics::Complex s : numerics::eigenvalues(*block)) see(q, s);
}

/// The kept mode whose value(q, s) is largest.  Of more than `most` wavenumbers it looks at every k-th, then at all
/// near the best one: rates are roots of polynomials of low degree in q, far smoother than that.
template <class Value>
FastestGrowth largest(const numerics::System& system, Value value) {
    constexpr std::size_t most = std::size_t{1} << 17;
    const std::vector<double> q = numerics::distinct_wavenumbers(system.grid, system.degree).q;
    FastestGrowth result{.rate = -std::numeric_limits<double>::infinity()};
    std::size_t at = 0;
    const auto look = [&](std::size_t i) {
        rates_at(system, q[i], [&](double, numerics::Complex s) {
            const double found = value(q[i], s);
            if (found > result.rate) result = {.rate = found, .q = q[i]}, at = i;
        });
    };
    const std::size_t every = (q.size() + most - 1) / most;
    for (std::size_t i = 0; i < q.size(); i += every) look(i);
    if (every == 1) return result;
    look(q.size() - 1);
    const std::size_t begin = at - std::min(at, every), end = std::min(q.size(), at + every);
    for (std::size_t i = begin; i < end; ++i) look(i);
    return result;
}
}  // namespace

FastestGrowth fastest_growth(const numerics::System& system) {
    return largest(system, [](double q, numerics::Complex s) {
        const bool is_conserved = q == 0.0 && s == 0.0;
        return is_conserved ? -std::numeric_limits<double>::infinity() : s.real();
    });
}

double fastest_rate(const numerics::System& system) {
    return largest(system, [](double, numerics::Complex s) { return std::abs(s); }).rate;
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
