// physics/integrated.cpp: what rods and beads may not reach, and the cost of their equations.
#include "drover/physics/integrated.hpp"

#include "drover/physics/density_extremes.hpp"
#include "program_functions.hpp"

namespace drover::physics {

namespace {
/// Some force is divided by m rho.
bool has_mass_of_beads(const Equations& e) {
    if (e.form.velocity != Velocity::dynamic || e.form.bead_density < 0) return false;
    for (std::size_t n = 0; n < e.terms().size(); ++n)
        if (e.is_force(n) && e.terms()[n] != "inertia.advection") return true;
    return false;
}
}  // namespace

model::Integrated integrated(const Equations& e, const Reference& about, const Dealiasing& dealiasing) {
    require_functions(e.model);
    model::Integrated what{.equations = e.solver(about), .kept_degree = kept_degree(e, dealiasing)};
    const int rho = e.component(FieldIndex::bead_density), sigma = e.component(FieldIndex::rod_density);
    for (const int k : {rho, sigma})
        if (k >= 0) what.watched.push_back(k);
    what.check = [model = static_cast<const CompiledModel&>(e), has_beads = rho >= 0, has_rods = sigma >= 0,
                  divisors = Divisors{.by_bead_density = has_mass_of_beads(e), .by_drag = has_pointwise_velocity(e)}](
                     std::span<const model::Range> found) {
        Extremes extremes;
        if (has_beads) extremes.min_bead = found.front().min, extremes.max_bead = found.front().max;
        if (has_rods) extremes.min_rod = found.back().min, extremes.max_rod = found.back().max;
        check_extremes(model, extremes, divisors);
    };
    if (e.model.approximation.quasi_linear) what.long_waves = e.model.approximation.quasi_linear_above;
    what.turning = {e.form.polar_order};
    if (e.form.bead_velocity >= 0) what.turning.push_back(e.form.bead_velocity);
    return what;
}

model::Integrated integrated(const Model& model, const Dealiasing& dealiasing) {
    return integrated(Equations(model), reference(model.uniform), dealiasing);
}

bool is_nonlinear(const Equations& equations) {
    return equations.solver(reference(equations.model.uniform)).has_nonlinear_part();
}

}  // namespace drover::physics
