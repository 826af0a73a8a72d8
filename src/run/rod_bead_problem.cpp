// run/rod_bead_problem.cpp: a run of the fields of rods and beads.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/physics/integrated.hpp"
#include "run/field_problem.hpp"
#include "run/grid_run.hpp"

namespace drover::run {

namespace {
/// Polar order of full alignment, or at which the saturation balances the growth, whichever is larger.
double order_size(const physics::Equations& equations, double driven) {
    const physics::UniformState& uniform = equations.model.uniform;
    const auto at = [&](const physics::Coefficient& c) {
        return c.at(uniform.bead_density, uniform.rod_density).value;
    };
    const double full = equations.form.order_is_density ? uniform.rod_density : 1.0, b = at(equations.saturation);
    if (!(b > 0.0)) return full;
    const double growth = std::abs(at(equations.relaxation)) + std::abs(at(equations.weathercock)) * driven;
    return std::max(full, std::sqrt(growth / b));
}

/// Of each component: its size in the model.
std::vector<double> sizes_of(const physics::Equations& equations, const io::Scene& scene) {
    const physics::Form& form = equations.form;
    const physics::Model& model = equations.model;
    const physics::UniformState& uniform = model.uniform;
    const double drag = equations.drag.at(uniform.bead_density, uniform.rod_density).value;
    const double drive = std::abs(equations.driving.at(uniform.bead_density, uniform.rod_density).value);
    const double order = order_size(equations, drag > 0.0 ? drive / drag : 0.0);
    std::vector<double> sizes(physics::component_names(form).size(), order);
    const auto set = [&](int first, int count, double size) {
        if (first >= 0) std::fill_n(sizes.begin() + first, count, size);
    };
    set(form.bead_density, 1, uniform.bead_density);
    set(form.rod_density, 1, uniform.rod_density);
    set(form.bead_velocity, 2, 0.0);  // unknown with forces written as text
    if (!model.text_terms.empty()) return sizes;
    const numerics::Grid& grid = scene.grid;
    const double largest_q = std::numbers::pi * std::hypot(grid.nx / grid.lx, grid.ny / grid.ly);
    const double pressure =
        std::abs(model.stiffness.beads) * uniform.bead_density + std::abs(model.stiffness.rods) * uniform.rod_density;
    const double applied = model.force.kind == "none" ? 0.0 : std::hypot(model.force.x, model.force.y);
    const double force = (drive + std::abs(model.driving.cubic) * order * order) * order + pressure * largest_q +
                         applied / (model.force.kind == "point" ? numerics::area(grid) : 1.0);
    // Without drag, a force accelerates the beads to the end of the run.
    set(form.bead_velocity, 2, force / std::max(drag, model.inertia.bead_mass * uniform.bead_density / scene.time.end));
    return sizes;
}

std::string likely_cause(const physics::Equations& equations, const numerics::System& linear) {
    const physics::FastestGrowth growth = physics::fastest_growth(linear);
    if (growth.rate > 0.0)
        return text(
            "a linear mode grows at {:.3g} /s (|q| = {:.3g} /mm) and {}", growth.rate, growth.q,
            equations.saturation.is_active()
                ? "relaxation.saturation does not stop it; or the time step is too large for the nonlinear terms"
                : "this model has no term to stop it (relaxation.saturation = 0)");
    if (equations.saturation.is_active()) return "the time step is too large for the nonlinear terms";
    return "the time step is too large for the nonlinear terms, or order grows where the densities have changed and "
           "this model has no term to stop it (relaxation.saturation = 0)";
}

std::string term_not_finite(const io::Scene& scene, double t, const numerics::Spectra& state) {
    Threads one(1);
    const auto is_bad = [&](const physics::Model& model) {
        const numerics::System system = model::system_of(physics::integrated(model, scene.dealiasing), scene.grid, one);
        numerics::Spectra rate(scene.grid, state.count());
        try {
            if (system.nonlinear) system.nonlinear(t, state, rate);
        } catch (const Error&) {  // a density, not a text
            return false;
        }
        return !std::all_of(rate.values.begin(), rate.values.end(),
                            [&](numerics::Complex value) { return is_finite(value, state.size); });
    };
    physics::Model alone = scene.model;
    for (const physics::TextTerm& term : scene.model.text_terms) {
        if (!term.function.empty()) continue;
        alone.text_terms = {term};
        if (!is_bad(alone)) continue;
        std::vector<std::string> texts;
        for (const auto* list : {&term.value, &term.flux})
            for (const physics::WrittenExpression& one_text : *list) texts.push_back(one_text.text);
        return text("the term of {} written as text, ({}), is not finite there", term.of, joined(texts));
    }
    return "";
}
}  // namespace

void complete_rod_bead(const io::Scene& scene, FieldProblem& problem) {
    const physics::Equations equations(scene.model);
    problem.sizes = sizes_of(equations, scene);
    problem.likely_cause = [equations](const numerics::System& linear, double) {
        return likely_cause(equations, linear);
    };
    problem.term_not_finite = [scene](double t, const numerics::Spectra& state) {
        return term_not_finite(scene, t, state);
    };
}

}  // namespace drover::run
