// run/rod_bead_problem.cpp: a run of the fields of rods and beads.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "drover/measure/fields.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/energy.hpp"
#include "drover/physics/initial_state.hpp"
#include "drover/physics/integrated.hpp"
#include "run/field_problem.hpp"
#include "run/grid_run.hpp"
#include "run/scene_equations.hpp"

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

FieldObserver observer_of(const io::Scene& scene, const physics::Equations& equations, int degree, Threads& threads,
                          bool whole) {
    struct Observer {
        Observer(const io::Scene& scene, const physics::Form& the_form, int degree, Threads& threads)
            : form(the_form),
              setting(measure::make_field_setting(scene.grid, form, degree)),
              transform(scene.grid, degree, threads) {}

        physics::Form form;
        measure::FieldSetting setting;
        numerics::Transform transform;
        numerics::Spectra velocity = {};
        std::optional<physics::EnergyMeter> energy = {};
    };
    const auto own = std::make_shared<Observer>(scene, equations.form, degree, threads);
    if (whole && scene.output.powers) {
        own->energy.emplace(equations, scene.grid, scene.dealiasing, threads);
        own->setting.terms = own->energy->terms();
    }
    own->setting.watches_error = whole && scene.time.max_error > 0.0;
    if (own->form.velocity != physics::Velocity::absent) own->velocity = numerics::Spectra(scene.grid, 2);
    return field_observer(measure::field_observables(own->setting), [own](const FieldState& state) {
        const physics::Form& form = own->form;
        if (form.velocity == physics::Velocity::slaved) own->transform.forward(state.balanced, own->velocity);
        if (form.velocity == physics::Velocity::dynamic)
            for (int axis = 0; axis < 2; ++axis)
                std::ranges::copy(state.spectra[form.bead_velocity + axis], own->velocity[axis].begin());
        std::optional<physics::EnergyBudget> energy;
        if (own->energy) energy = own->energy->measure(state.time, state.spectra);
        return measure::FieldMoment{.setting = own->setting,
                                    .spectra = state.spectra,
                                    .fields = state.fields,
                                    .velocity = own->velocity.size > 0 ? &own->velocity : nullptr,
                                    .slaved_velocity = &state.balanced,
                                    .energy = std::move(energy),
                                    .step_error = state.step_error};
    });
}
}  // namespace

FieldProblem rod_bead_problem(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    FieldProblem problem{.integrated = integrated_of(scene)};
    for (const physics::Component& one : physics::component_names(equations.form))
        problem.components.push_back({one.name, one.unit, one.meaning, {"y", "x"}});
    if (equations.form.velocity == physics::Velocity::slaved)
        for (const char* axis : {"x", "y"})
            problem.balanced.push_back(
                {text("bead_velocity_{}", axis),
                 "mm s-1",
                 text("velocity of the beads along {}, in balance with the forces on them", axis),
                 {"y", "x"}});
    problem.sizes = sizes_of(equations, scene);
    problem.start = [scene](const numerics::System& linear, Threads& threads) {
        return physics::initial_spectra(scene.initial, scene.model, linear, static_cast<std::uint64_t>(scene.run.seed),
                                        threads);
    };
    problem.observer = [scene, equations, degree = problem.integrated.kept_degree](Threads& threads, bool whole) {
        return observer_of(scene, equations, degree, threads, whole);
    };
    problem.likely_cause = [equations](const numerics::System& linear, double) {
        return likely_cause(equations, linear);
    };
    problem.term_not_finite = [scene](double t, const numerics::Spectra& state) {
        return term_not_finite(scene, t, state);
    };
    return problem;
}

}  // namespace drover::run
