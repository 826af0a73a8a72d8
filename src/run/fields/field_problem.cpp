// run/fields/field_problem.cpp: the components of a run of fields, their observables, and states as numbers.
#include "run/fields/field_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "model/start.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/scene_support.hpp"

namespace drover::run {

namespace {
std::vector<files::Quantity> quantities(const std::vector<model::StateComponent>& components) {
    return mapped(components, [](const model::StateComponent& one) {
        return files::Quantity{one.name, one.unit, one.meaning, {"y", "x"}};
    });
}
}  // namespace

FieldObserver::FieldObserver(measure::FieldSetting setting, Threads& threads,
                             std::unique_ptr<model::EnergyMeter> energy)
    : setting_(std::move(setting)),
      transform_(setting_.grid, setting_.degree, threads),
      balanced_(setting_.grid, setting_.in_balance),
      rows_(measure::field_observables(setting_)),
      energy_(std::move(energy)) {}

std::vector<files::Quantity> FieldObserver::quantities() const { return quantities_of(rows_); }

std::size_t FieldObserver::values() const {
    std::size_t values = 0;
    for (const auto& row : rows_) values += measure::size_of(row.axes);
    return values;
}

std::vector<std::vector<double>> FieldObserver::measure(const FieldState& state) {
    if (balanced_.count() > 0) transform_.forward(state.balanced, balanced_);
    measure::FieldMoment moment{.setting = setting_,
                                .state = state.spectra,
                                .state_on_grid = state.fields,
                                .balanced = balanced_,
                                .balanced_on_grid = state.balanced,
                                .step_error = state.step_error};
    if (energy_) moment.energy = energy_->measure(state.time, state.spectra);
    return measure_all(rows_, moment);
}

SharedObserver field_observer(const io::Scene& scene, const model::Integrated& what, Threads& threads) {
    measure::FieldSetting setting = measure::make_field_setting(what.equations, scene.grid, what.kept_degree);
    setting.watches_error = scene.time.max_error > 0.0;
    if (!scene.output.powers) return std::make_shared<FieldObserver>(std::move(setting), threads);
    setting.terms = names_of_terms(scene, what.equations);
    return std::make_shared<FieldObserver>(std::move(setting), threads,
                                           std::make_unique<model::EnergyMeter>(what.equations, scene.grid,
                                                                                what.kept_degree, threads));
}

SharedObserver observer_of_state(const SharedObserver& whole, Threads& threads) {
    measure::FieldSetting setting = whole->setting();
    if (!setting.watches_error && !setting.terms) return whole;
    setting.watches_error = false;
    setting.terms.reset();
    return std::make_shared<FieldObserver>(std::move(setting), threads);
}

void check_result_names(const io::Scene& scene) {
    if (scene.kind != io::SceneKind::model) return;
    const model::Equations equations = equations_of(scene);
    numerics::Grid small = scene.grid;  // the names do not depend on it
    small.nx = std::min(small.nx, 8);
    small.ny = std::min(small.ny, 8);
    const measure::FieldSetting setting = measure::make_field_setting(equations, small, 1);
    const auto series = mapped(measure::field_observables(setting), [](const auto& row) {
        return measure::recorded_series(row, std::vector<double>(measure::size_of(row.axes)));
    });
    std::vector<std::string> names;
    for (const measure::SummaryRow& row : measure::summarise(measure::field_recording(setting, series)).rows)
        for (const char* ending : measure::result_endings) names.push_back(row.name + ending);
    std::ranges::sort(names);
    const auto twice = std::ranges::adjacent_find(names);
    if (twice == names.end()) return;
    std::vector<std::string> fields;
    for (const model::Field& field : equations.model().fields)
        if (twice->find(field.name) != std::string::npos) fields.push_back(field.name);
    fail_input({scene.file},
               "two results of the fields {} would both be named {} in archives; rename one of the fields",
               joined(fields), *twice);
}

FieldProblem field_problem(const io::Scene& scene) {
    FieldProblem problem{.integrated = integrated_in_run(scene)};
    problem.components = quantities(model::components_of_state(problem.integrated.equations));
    problem.balanced = quantities(model::components_in_balance(problem.integrated.equations));
    complete_problem(scene, problem);
    return problem;
}

bool is_finite(numerics::Complex value, std::size_t modes) {
    const double max = std::numeric_limits<double>::max() / static_cast<double>(2 * modes);
    return std::abs(value.real()) < max && std::abs(value.imag()) < max;
}

void find_balanced(const model::FieldEvolution& evolution, double time, const numerics::Spectra& state,
                   numerics::Fields& to) {
    if (to.count() == 0) return;
    const numerics::Fields now = evolution.balanced(time, state);
    std::ranges::copy(now.values, to.values.begin());
}

void append_numbers(const numerics::Spectra& state, std::vector<double>& to) {
    to.reserve(to.size() + 2 * state.values.size());
    for (const numerics::Complex value : state.values) {
        to.push_back(value.real());
        to.push_back(value.imag());
    }
}

void take_numbers(std::span<const double> numbers, numerics::Spectra& state) {
    for (std::size_t m = 0; m < state.values.size(); ++m) state.values[m] = {numbers[2 * m], numbers[2 * m + 1]};
}

}  // namespace drover::run
