// run/field_problem.cpp: the components of a run of fields, and their observables.
#include "run/field_problem.hpp"

#include <memory>

#include "drover/numerics/transform.hpp"
#include "measure/fields.hpp"
#include "model/start.hpp"
#include "run/sample_recording.hpp"
#include "run/scene_equations.hpp"

namespace drover::run {

namespace {
std::vector<files::Quantity> quantities(const std::vector<model::StateComponent>& components) {
    std::vector<files::Quantity> result;
    for (const model::StateComponent& one : components) result.push_back({one.name, one.unit, one.meaning, {"y", "x"}});
    return result;
}

struct Observer {
    Observer(std::shared_ptr<const measure::FieldSetting> of_run, Threads& threads)
        : setting(std::move(of_run)),
          transform(setting->grid, setting->degree, threads),
          balanced(setting->grid, setting->in_balance),
          rows(measure::field_observables(*setting)) {}

    std::shared_ptr<const measure::FieldSetting> setting;
    numerics::Transform transform;
    numerics::Spectra balanced;
    measure::Observables<measure::FieldMoment> rows;
    std::shared_ptr<model::EnergyMeter> energy = {};
};

FieldObserver observer_of(const std::shared_ptr<Observer>& own) {
    FieldObserver result{.axes = measure::axes_of(own->rows),
                         .quantities = quantities_of(own->rows),
                         .values = 0,
                         .setting = own->setting,
                         .measure = {}};
    for (const auto& row : own->rows) result.values += measure::size_of(row.axes);
    result.measure = [own](const FieldState& state) {
        if (own->balanced.count() > 0) own->transform.forward(state.balanced, own->balanced);
        measure::FieldMoment moment{.setting = *own->setting,
                                    .state = state.spectra,
                                    .state_on_grid = state.fields,
                                    .balanced = own->balanced,
                                    .balanced_on_grid = state.balanced,
                                    .step_error = state.step_error};
        if (own->energy) moment.energy = own->energy->measure(state.time, state.spectra);
        return measure_all(own->rows, moment);
    };
    return result;
}
}  // namespace

FieldObserver field_observer(const io::Scene& scene, const model::Integrated& what, Threads& threads) {
    const auto setting = std::make_shared<measure::FieldSetting>(
        measure::make_field_setting(what.equations, scene.grid, what.kept_degree));
    setting->watches_error = scene.time.max_error > 0.0;
    std::shared_ptr<model::EnergyMeter> energy;
    if (scene.output.powers) {
        energy = std::make_shared<model::EnergyMeter>(what.equations, scene.grid, what.kept_degree, threads);
        setting->terms = names_of_terms(scene, what.equations);
    }
    const auto own = std::make_shared<Observer>(setting, threads);
    own->energy = energy;
    return observer_of(own);
}

FieldObserver observer_of_state(const FieldObserver& whole, Threads& threads) {
    if (!whole.setting->watches_error && !whole.setting->terms) return whole;
    const auto setting = std::make_shared<measure::FieldSetting>(*whole.setting);
    setting->watches_error = false;
    setting->terms.reset();
    return observer_of(std::make_shared<Observer>(setting, threads));
}

FieldProblem field_problem(const io::Scene& scene) {
    FieldProblem problem{.integrated = integrated_of(scene)};
    problem.components = quantities(model::components_of_state(problem.integrated.equations));
    problem.balanced = quantities(model::components_in_balance(problem.integrated.equations));
    complete_problem(scene, problem);
    return problem;
}

}  // namespace drover::run
