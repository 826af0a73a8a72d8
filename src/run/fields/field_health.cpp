// run/fields/field_health.cpp: sizes of fields, and the diagnosis of a run that failed.
#include "run/fields/field_health.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/units.hpp"
#include "measure/fields.hpp"

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

struct Peak {
    double value = 0.0;
    std::size_t x = 0, y = 0;  ///< cell
};
Peak peak_of(const numerics::Grid& grid, numerics::Transform& transform, const numerics::Spectra& state,
             int component) {
    numerics::Fields fields(grid, state.count());
    transform.backward(state, fields);
    const std::span<const double> field = std::as_const(fields)[component];
    const auto largest = std::ranges::max_element(field, [](double a, double b) { return std::abs(a) < std::abs(b); });
    const auto cell = static_cast<std::size_t>(largest - field.begin()), nx = static_cast<std::size_t>(grid.nx);
    return {.value = *largest, .x = cell % nx, .y = cell / nx};
}

/// Components of one field: those that turn occupy two.
struct FieldRange {
    std::string name;
    int first = 0, count = 1;
};
std::vector<FieldRange> field_ranges(const model::Equations& equations) {
    std::vector<FieldRange> ranges;
    int first = 0;
    for (const model::Field& field : equations.model().fields) {
        if (field.left != model::LeftSide::rate) continue;
        ranges.push_back({field.name, first, model::components(field)});
        first += ranges.back().count;
    }
    return ranges;
}

/// Change of a component, relative to its size, which is at least `scale`.
double change_between(const numerics::Grid& grid, std::span<const Complex> before, std::span<const Complex> after,
                      double scale) {
    const double size = std::max(root_mean_square(grid, before), scale);
    return size > 0.0 ? root_mean_square(grid, after, before) / size : 0.0;
}

/// Fraction of the variance of a field in the shortest waves of the grid.
double tail_of(const numerics::System& system, const numerics::Spectra& state, const FieldRange& field) {
    return measure::tail_of(system.grid, system.degree, state, field.first, field.count);
}

/// The field that changed most in the last step before a failure.
struct FirstFailure {
    FieldRange field;
    double change = 0.0;  ///< relative to its size
    double tail = 0.0;
    std::int64_t step = 0;
};

/// Repeats the steps since the check before the last, up to the one that fails.
FirstFailure find_first_failure(model::FieldEvolution& evolution, const FieldHealth& health, std::int64_t end) {
    numerics::Spectra before = numerics::with_kept(evolution.linear(), health.earlier), state = before;
    FirstFailure found;
    for (std::int64_t step = health.earlier_step; step < end; ++step) {
        try {
            evolution.advance(step, state);
        } catch (const Error&) {
            return found;
        }
        if (!std::ranges::all_of(state.values, [&](Complex value) { return is_finite(value, state.size); }))
            return found;
        found = {};
        for (const FieldRange& field : field_ranges(evolution.what().equations))
            for (int c = field.first; c < field.first + field.count; ++c)
                if (const double change = change_between(evolution.linear().grid, before[c], state[c],
                                                         health.scales[static_cast<std::size_t>(c)]);
                    change > found.change)
                    found = {.field = field,
                             .change = change,
                             .tail = tail_of(evolution.linear(), state, field),
                             .step = step + 1};
        before = state;
    }
    return found;
}

std::string cause_of(const Diagnosed& run, double tail) {
    return likely_cause(run.scene, run.problem.integrated.equations, run.evolution.linear(), tail);
}

/// Reports the non-finite mode with the smallest wavenumber of the field that failed first, and where the field was
/// largest when last finite.
[[noreturn]] void report_not_finite(const Diagnosed& run, numerics::Transform& transform,
                                    const numerics::Spectra& state, std::int64_t step, const FieldHealth& health) {
    const numerics::System& linear = run.evolution.linear();
    const FirstFailure first = find_first_failure(run.evolution, health, step);
    const std::size_t width = numerics::columns(linear.grid);
    int component = 0;
    std::size_t mode = 0;
    double min_q = INFINITY;
    bool is_first = false;
    for (int c = 0; c < state.count(); ++c)
        for (std::size_t m = 0; m < state.size; ++m) {
            if (is_finite(state[c][m], state.size)) continue;
            const bool in_first = c >= first.field.first && c < first.field.first + first.field.count;
            const numerics::Wavevector q = numerics::wavevector(linear.grid, m % width, m / width);
            if (in_first < is_first || (in_first == is_first && std::hypot(q.x, q.y) >= min_q)) continue;
            is_first = in_first;
            min_q = std::hypot(q.x, q.y);
            component = c;
            mode = m;
        }
    const numerics::Spectra last = numerics::with_kept(linear, health.healthy);
    const Peak peak = peak_of(linear.grid, transform, last, component);
    const double dt = run.scene.time.dt;
    constexpr double near_overflow = 1e50;  // whose powers are not finite, whatever the term
    const std::string term =
        std::abs(peak.value) > near_overflow
            ? ""
            : term_not_finite(run.scene, run.problem.integrated, static_cast<double>(health.step) * dt, last);
    fail_run(
        "the solution became NaN or infinite at or before step {} (t = {}): {}, mode ({}, {}), dt = {}; its "
        "largest value was {:.3g} in cell ({}, {}) when last finite; likely cause: {}; any checkpoint is "
        "still valid",
        step, io::in_unit("{:.6g}", static_cast<double>(step) * dt, "s", run.scene.units),
        run.problem.components[static_cast<std::size_t>(component)].name, mode % width,
        numerics::mode_number_y(linear.grid, mode / width), dt, peak.value, peak.x, peak.y,
        term.empty() ? cause_of(run, tail_of(linear, last, {"", component, 1}))
                     : term + ": give it a finite value where the fields vanish");
}

/// Sizes in the model, or at the start if larger.
void set_scales(const model::Equations& equations, const std::vector<double>& sizes, FieldHealth& health) {
    health.scales = sizes;
    for (const FieldRange& field : field_ranges(equations)) {
        const auto first = static_cast<std::size_t>(field.first), end = first + static_cast<std::size_t>(field.count);
        double scale = sizes[first];
        for (std::size_t c = first; scale > 0.0 && c < end; ++c) scale = std::max(scale, health.start[c]);
        std::fill_n(health.scales.begin() + field.first, field.count, scale);
    }
}

/// A size in the model is at least what is known without a search.
void search_scales(const Diagnosed& run, FieldHealth& health) {
    if (std::exchange(health.has_searched, true)) return;
    const model::Integrated& what = run.problem.integrated;
    set_scales(what.equations, searched_sizes(run.scene, what), health);
}
}  // namespace

FieldHealth make_field_health(const FieldProblem& problem, const numerics::System& linear,
                              const numerics::Spectra& initial) {
    FieldHealth health;
    restore_field_health(linear, initial, 0, health);
    for (int c = 0; c < initial.count(); ++c) health.start.push_back(root_mean_square(linear.grid, initial[c]));
    set_scales(problem.integrated.equations, problem.sizes, health);
    return health;
}

void restore_field_health(const numerics::System& system, const numerics::Spectra& state, std::int64_t step,
                          FieldHealth& health) {
    numerics::store_kept(system, state, health.healthy);
    health.earlier = health.healthy;
    health.step = health.earlier_step = step;
}

void check_field_health(const Diagnosed& run, numerics::Transform& transform, const numerics::Spectra& state,
                        std::int64_t step, FieldHealth& health) {
    const numerics::System& linear = run.evolution.linear();
    for (const Complex value : state.values)
        if (!is_finite(value, state.size)) {
            search_scales(run, health);
            report_not_finite(run, transform, state, step, health);
        }
    for (int c = 0; c < state.count(); ++c) {
        const files::Quantity& component = run.problem.components[static_cast<std::size_t>(c)];
        const double size = root_mean_square(linear.grid, state[c]);
        const double& scale = health.scales[static_cast<std::size_t>(c)];
        if (size > max_field_size * std::max(scale, health.start[static_cast<std::size_t>(c)]))
            search_scales(run, health);
        if (size <= max_field_size * scale || scale == 0.0) continue;
        const Peak peak = peak_of(linear.grid, transform, state, c);
        fail_run(
            "the run diverged at or before step {} (t = {}): the root mean square of {} is {}; "
            "expected at most {:.0e} times its size in this model, {:.3g}; its largest value is {:.3g} in cell "
            "({}, {}), dt = {}; likely cause: {}; any earlier checkpoint is still valid",
            step, io::in_unit("{:.6g}", static_cast<double>(step) * run.scene.time.dt, "s", run.scene.units),
            component.name, io::in_unit("{:.3g}", size, component.unit, run.scene.units), max_field_size, scale,
            peak.value, peak.x, peak.y, run.scene.time.dt, cause_of(run, tail_of(linear, state, {"", c, 1})));
    }
    if (step == health.step) return;  // checked before
    std::swap(health.earlier, health.healthy);
    health.earlier_step = std::exchange(health.step, step);
    numerics::store_kept(linear, state, health.healthy);
}

void fail_step(const Diagnosed& run, const FieldHealth& health, std::int64_t step, const model::DomainFailure& error) {
    // A field that changes by less than this in a step does not fail because of the step.
    constexpr double min_change = 0.05;
    const FirstFailure first = find_first_failure(run.evolution, health, step);
    if (first.change < min_change || first.field.first == error.component) fail_run("{}", error.what());
    fail_run(
        "{} became unstable: in step {} (t = {}) it changed by {:.3g} times its size, with {:.2g} of its "
        "variance in the shortest waves of the grid: choose time.dt = {} or smaller, or a finer grid; then {}",
        first.field.name, first.step,
        io::in_unit("{:.6g}", static_cast<double>(first.step) * run.scene.time.dt, "s", run.scene.units), first.change,
        first.tail, 0.5 * run.scene.time.dt, error.what());
}

}  // namespace drover::run
