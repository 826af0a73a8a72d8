// run/field_health.cpp: sizes of fields, and the diagnosis of a run that failed.
#include "run/field_health.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drover/measure/fields.hpp"
#include "drover/physics/right_hand_side.hpp"
#include "run/grid_run.hpp"

namespace drover::run {

namespace {
using numerics::Complex;

/// Root mean square over the cell of a component, or of its difference from another state.
double root_mean_square(const numerics::Grid& grid, std::span<const Complex> values,
                        std::span<const Complex> minus = {}) {
    const std::size_t width = numerics::columns(grid);
    double sum = 0.0;
    for (std::size_t m = 0; m < values.size(); ++m) {
        const Complex value = minus.empty() ? values[m] : values[m] - minus[m];
        sum += numerics::mode_weight(grid, m % width) * std::norm(value);
    }
    return std::sqrt(sum);
}

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

std::string likely_cause(const physics::FieldEvolution& evolution) {
    const physics::Equations& equations = evolution.equations();
    const physics::FastestGrowth growth = physics::fastest_growth(evolution.system());
    if (growth.rate > 0.0)
        return text(
            "a linear mode grows at {:.3g} /s (|q| = {:.3g} /mm) and {}", growth.rate, growth.q,
            equations.saturation.is_active()
                ? "relaxation.saturation does not stop it; or the time step is too large for the nonlinear terms"
                : "this model has no term to stop it (relaxation.saturation = 0)");
    if (equations.saturation.is_active()) return "the time step is too large for the nonlinear terms";
    return "the time step is too large for the nonlinear terms, or order grows where the densities have changed and "
           "this "
           "model has no term to stop it (relaxation.saturation = 0)";
}

/// The text of a term that is not finite somewhere in a state, such as a quotient 0/0; "" if all are.
std::string not_finite_term(const io::Scene& scene, double t, const numerics::Spectra& state) {
    Threads one(1);
    const auto is_bad = [&](const physics::Model& model) {
        const physics::Equations equations(model);
        const physics::Reference about = physics::reference(model.uniform);
        const numerics::System system = physics::linear_system(equations, scene.grid, about, scene.dealiasing);
        physics::RightHandSide remainder(equations, system, about, one);
        numerics::Spectra rate(scene.grid, state.count());
        try {
            remainder(t, state, rate);
        } catch (const Error&) {  // a density, not a text
            return false;
        }
        return !std::all_of(rate.values.begin(), rate.values.end(),
                            [&](Complex value) { return is_finite(value, state.size); });
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

struct Peak {
    double value = 0.0;
    std::size_t x = 0, y = 0;  ///< cell
};
Peak peak_of(const numerics::Grid& grid, numerics::Transform& transform, const numerics::Spectra& state,
             int component) {
    numerics::Fields fields(grid, state.count());
    transform.backward(state, fields);
    const std::span<const double> field = std::as_const(fields)[component];
    const auto largest =
        std::max_element(field.begin(), field.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    const auto cell = static_cast<std::size_t>(largest - field.begin()), nx = static_cast<std::size_t>(grid.nx);
    return {.value = *largest, .x = cell % nx, .y = cell / nx};
}

/// Components of one field: vectors occupy two.
struct FieldRange {
    std::string name;
    int first = 0, count = 1;
};
std::vector<FieldRange> field_ranges(const physics::Form& form) {
    std::vector<FieldRange> ranges;
    for (const auto& [name, first, count] :
         {std::tuple{"bead_density", form.bead_density, 1}, std::tuple{"rod_density", form.rod_density, 1},
          std::tuple{"bead_velocity", form.bead_velocity, 2}, std::tuple{"polar_order", form.polar_order, 2}})
        if (first >= 0) ranges.push_back({name, first, count});
    return ranges;
}

/// Change of each component, relative to its size.
std::vector<double> changes_between(const numerics::Grid& grid, const numerics::Spectra& before,
                                    const numerics::Spectra& after, const std::vector<double>& scales) {
    std::vector<double> changes;
    for (int c = 0; c < after.count(); ++c) {
        const double size = std::max(root_mean_square(grid, before[c]), scales[static_cast<std::size_t>(c)]);
        changes.push_back(size > 0.0 ? root_mean_square(grid, after[c], before[c]) / size : 0.0);
    }
    return changes;
}

/// Fraction of the variance of a field in the shortest waves of the grid.
double tail_of(const numerics::System& system, const numerics::Spectra& state, const FieldRange& field) {
    const std::size_t width = numerics::columns(system.grid);
    double tail = 0.0, all = 0.0;
    for (int c = field.first; c < field.first + field.count; ++c)
        for (std::size_t m = 1; m < state.size; ++m) {
            const double power = numerics::mode_weight(system.grid, m % width) * std::norm(state[c][m]);
            all += power;
            if (measure::is_in_tail(system.grid, system.degree, m % width, m / width)) tail += power;
        }
    return all > 0.0 ? tail / all : 0.0;
}

/// The field that changed most in the last step before a failure.
struct FirstFailure {
    FieldRange field;
    double change = 0.0;  ///< relative to its size
    double tail = 0.0;
    std::int64_t step = 0;
};

/// Repeats the steps since the check before the last, up to the one that fails.
FirstFailure find_first_failure(physics::FieldEvolution& evolution, const FieldHealth& health, std::int64_t end) {
    numerics::Spectra before = numerics::with_kept(evolution.system(), health.earlier), state = before;
    FirstFailure found;
    for (std::int64_t step = health.earlier_step; step < end; ++step) {
        try {
            evolution.advance(step, state);
        } catch (const Error&) {
            return found;
        }
        if (!std::all_of(state.values.begin(), state.values.end(),
                         [&](Complex value) { return is_finite(value, state.size); }))
            return found;
        const std::vector<double> changes = changes_between(evolution.system().grid, before, state, health.scales);
        found = {};
        for (const FieldRange& field : field_ranges(evolution.equations().form))
            for (int c = field.first; c < field.first + field.count; ++c)
                if (const double change = changes[static_cast<std::size_t>(c)]; change > found.change)
                    found = {.field = field,
                             .change = change,
                             .tail = tail_of(evolution.system(), state, field),
                             .step = step + 1};
        before = state;
    }
    return found;
}
/// Reports the non-finite mode with the smallest wavenumber of the field that failed first, and where the field was
/// largest when last finite.
[[noreturn]] void report_not_finite(physics::FieldEvolution& evolution, const io::Scene& scene,
                                    numerics::Transform& transform, const numerics::Spectra& state, std::int64_t step,
                                    const FieldHealth& health) {
    const std::vector<physics::Component> names = physics::component_names(evolution.equations().form);
    const FirstFailure first = find_first_failure(evolution, health, step);
    const std::size_t width = numerics::columns(scene.grid);
    int component = 0;
    std::size_t mode = 0;
    double min_q = INFINITY;
    bool is_first = false;
    for (int c = 0; c < state.count(); ++c)
        for (std::size_t m = 0; m < state.size; ++m) {
            if (is_finite(state[c][m], state.size)) continue;
            const bool in_first = c >= first.field.first && c < first.field.first + first.field.count;
            const numerics::Wavevector q = numerics::wavevector(scene.grid, m % width, m / width);
            if (in_first < is_first || (in_first == is_first && std::hypot(q.x, q.y) >= min_q)) continue;
            is_first = in_first;
            min_q = std::hypot(q.x, q.y);
            component = c;
            mode = m;
        }
    const numerics::Spectra last = numerics::with_kept(evolution.system(), health.healthy);
    const Peak peak = peak_of(scene.grid, transform, last, component);
    const std::string term = not_finite_term(scene, static_cast<double>(health.step) * scene.time.dt, last);
    fail_run(
        "the solution became NaN or infinite at or before step {} (t = {:.6g} s): {}, mode ({}, {}), dt = {}; its "
        "largest value was {:.3g} in cell ({}, {}) when last finite; likely cause: {}; the last checkpoint is good to "
        "restart from",
        step, static_cast<double>(step) * scene.time.dt, names[static_cast<std::size_t>(component)].name, mode % width,
        numerics::mode_number_y(scene.grid, mode / width), scene.time.dt, peak.value, peak.x, peak.y,
        term.empty() ? likely_cause(evolution) : term + ": give it a finite value where the fields vanish");
}
}  // namespace

FieldHealth make_field_health(const physics::FieldEvolution& evolution, const io::Scene& scene,
                              const numerics::Spectra& initial) {
    const physics::Equations& equations = evolution.equations();
    const physics::Form& form = equations.form;
    const physics::Model& model = equations.model;
    const physics::UniformState& uniform = model.uniform;
    const double drag = equations.drag.at(uniform.bead_density, uniform.rod_density).value;
    const double drive = std::abs(equations.driving.at(uniform.bead_density, uniform.rod_density).value);
    const double order = order_size(equations, drag > 0.0 ? drive / drag : 0.0);
    double scale_of_velocity = 0.0;  // unknown with forces written as text
    if (model.text_terms.empty()) {
        const numerics::Grid& grid = scene.grid;
        const double largest_q = std::numbers::pi * std::hypot(grid.nx / grid.lx, grid.ny / grid.ly);
        const double pressure = std::abs(model.stiffness.beads) * uniform.bead_density +
                                std::abs(model.stiffness.rods) * uniform.rod_density;
        const double applied = model.force.kind == "none" ? 0.0 : std::hypot(model.force.x, model.force.y);
        const double force = (drive + std::abs(model.driving.cubic) * order * order) * order + pressure * largest_q +
                             applied / (model.force.kind == "point" ? numerics::area(grid) : 1.0);
        // Without drag, a force accelerates the beads to the end of the run.
        scale_of_velocity = force / std::max(drag, model.inertia.bead_mass * uniform.bead_density / scene.time.end);
    }
    FieldHealth health{.scales = std::vector<double>(static_cast<std::size_t>(initial.count()))};
    restore_field_health(evolution.system(), initial, 0, health);
    for (const FieldRange& field : field_ranges(form)) {
        double scale = order;
        if (field.first == form.bead_density) scale = uniform.bead_density;
        if (field.first == form.rod_density) scale = uniform.rod_density;
        if (field.first == form.bead_velocity) scale = scale_of_velocity;
        for (int c = field.first; scale > 0.0 && c < field.first + field.count; ++c)
            scale = std::max(scale, root_mean_square(scene.grid, initial[c]));
        std::fill_n(health.scales.begin() + field.first, field.count, scale);
    }
    return health;
}

void restore_field_health(const numerics::System& system, const numerics::Spectra& state, std::int64_t step,
                          FieldHealth& health) {
    numerics::store_kept(system, state, health.healthy);
    health.earlier = health.healthy;
    health.step = health.earlier_step = step;
}

void check_field_health(physics::FieldEvolution& evolution, const io::Scene& scene, numerics::Transform& transform,
                        const numerics::Spectra& state, std::int64_t step, FieldHealth& health) {
    for (const Complex value : state.values)
        if (!is_finite(value, state.size)) report_not_finite(evolution, scene, transform, state, step, health);
    const std::vector<physics::Component> names = physics::component_names(evolution.equations().form);
    for (int c = 0; c < state.count(); ++c) {
        const physics::Component& component = names[static_cast<std::size_t>(c)];
        const double size = root_mean_square(scene.grid, state[c]), scale = health.scales[static_cast<std::size_t>(c)];
        if (size <= max_field_size * scale || scale == 0.0) continue;
        const Peak peak = peak_of(scene.grid, transform, state, c);
        fail_run(
            "the solution lost its meaning at or before step {} (t = {:.6g} s): the root mean square of {} is {:.3g} "
            "{}; expected at most {:.0e} times its size in this model, {:.3g}; its largest value is {:.3g} in cell "
            "({}, {}), dt = {}; likely cause: {}; an earlier checkpoint is good to restart from",
            step, static_cast<double>(step) * scene.time.dt, component.name, size, component.unit, max_field_size,
            scale, peak.value, peak.x, peak.y, scene.time.dt, likely_cause(evolution));
    }
    if (step == health.step) return;  // checked before
    std::swap(health.earlier, health.healthy);
    health.earlier_step = std::exchange(health.step, step);
    numerics::store_kept(evolution.system(), state, health.healthy);
}

void fail_step(physics::FieldEvolution& evolution, const FieldHealth& health, std::int64_t step, double dt,
               const physics::DensityFailure& error) {
    // A field that changes by less than this in a step does not fail because of the step.
    constexpr double min_change = 0.05;
    const FirstFailure first = find_first_failure(evolution, health, step);
    if (first.change < min_change || first.field.first == evolution.equations().form.bead_density)
        fail_run("{}", error.what());
    fail_run(
        "{} became unstable: in step {} (t = {:.6g} s) it changed by {:.3g} times its size, with {:.2g} of its "
        "variance in the shortest waves of the grid: choose time.dt = {} or smaller, or a finer grid; then {}",
        first.field.name, first.step, static_cast<double>(first.step) * dt, first.change, first.tail, 0.5 * dt,
        error.what());
}

}  // namespace drover::run
