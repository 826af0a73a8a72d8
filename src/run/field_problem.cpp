// run/field_problem.cpp: the components of a run of fields, and their observables.
#include "run/field_problem.hpp"

#include <memory>
#include <optional>

#include "drover/measure/fields.hpp"
#include "drover/model/start.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/energy.hpp"
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
    Observer(measure::FieldSetting of_run, Threads& threads)
        : setting(std::move(of_run)),
          transform(setting.grid, setting.degree, threads),
          balanced(setting.grid, setting.in_balance) {}

    measure::FieldSetting setting;
    numerics::Transform transform;
    numerics::Spectra balanced;
    std::optional<physics::EnergyMeter> energy = {};
    measure::Observables<measure::FieldMoment> rows = {};
};
}  // namespace

FieldObserver field_observer(const io::Scene& scene, const model::Integrated& what, Threads& threads, bool whole) {
    const auto own =
        std::make_shared<Observer>(measure::make_field_setting(what.equations, scene.grid, what.kept_degree), threads);
    own->setting.watches_error = whole && scene.time.max_error > 0.0;
    if (whole && scene.output.powers) {
        own->energy.emplace(physics::Equations(scene.model), scene.grid, scene.dealiasing, threads);
        own->setting.terms = own->energy->terms();
    }
    own->rows = measure::field_observables(own->setting);
    FieldObserver result{.axes = measure::axes_of(own->rows),
                         .quantities = quantities_of(own->rows),
                         .values = 0,
                         .measure = {}};
    for (const auto& row : own->rows) result.values += measure::size_of(row.axes);
    result.measure = [own](const FieldState& state) {
        if (own->balanced.count() > 0) own->transform.forward(state.balanced, own->balanced);
        measure::FieldMoment moment{.setting = own->setting,
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

FieldProblem field_problem(const io::Scene& scene) {
    FieldProblem problem{.integrated = integrated_of(scene)};
    problem.components = quantities(model::components_of_state(problem.integrated.equations));
    problem.balanced = quantities(model::components_in_balance(problem.integrated.equations));
    if (scene.kind == io::SceneKind::model) complete_declared(scene, problem);
    else complete_rod_bead(scene, problem);
    return problem;
}

}  // namespace drover::run
