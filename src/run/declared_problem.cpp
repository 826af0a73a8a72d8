// run/declared_problem.cpp: a run of the fields of a declared model.
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "drover/measure/model_fields.hpp"
#include "drover/model/start.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/run/warnings.hpp"
#include "run/field_problem.hpp"
#include "run/growing_waves.hpp"
#include "run/scene_equations.hpp"

namespace drover::run {

namespace {
/// A quarter above the largest wavenumber at which the state of the references is unstable: patterns have such waves,
/// and errors of a pattern that is not resolved would seem to grow without limit.
double shortest_of_patterns(const model::Equations& equations, const numerics::Grid& grid, int degree) {
    const numerics::System system = equations.linear_system(grid, degree);
    const auto cut = [&](int points, double length) {
        return points > 1 ? 2.0 * std::numbers::pi / length * points / (system.degree + 1) : 0.0;
    };
    const double most = std::hypot(cut(grid.nx, grid.lx), cut(grid.ny, grid.ly));
    return 1.25 * largest_growing(system, most);
}

std::string likely_cause(const numerics::Grid& grid, double dt, double tail) {
    const bool coarse = tail > max_spectral_tail;
    return text(
        "the time step is too long for the products, {}no term of the equations limits its growth: choose "
        "time.dt = {}{}",
        coarse ? text("the grid is too coarse ({:.2g} of the variance is in the shortest waves), or ", tail) : "or ",
        0.5 * dt, coarse ? text(", or {}", grid_keys(grid, 2)) : "");
}

struct Observer {
    Observer(measure::ModelSetting of_run, Threads& threads)
        : setting(std::move(of_run)),
          transform(setting.grid.grid, setting.grid.degree, threads),
          balanced(setting.grid.grid, static_cast<int>(setting.components.size()) - setting.of_state) {}

    measure::ModelSetting setting;
    numerics::Transform transform;
    numerics::Spectra balanced;
};
}  // namespace

FieldProblem declared_problem(const io::Scene& scene) {
    FieldProblem problem{.integrated = integrated_of(scene)};
    const model::Equations& equations = problem.integrated.equations;
    const int degree = problem.integrated.kept_degree;
    const auto quantity = [](const model::StateComponent& one) {
        return files::Quantity{one.name, one.unit, one.meaning, {"y", "x"}};
    };
    for (const model::StateComponent& one : model::components_of_state(equations))
        problem.components.push_back(quantity(one));
    for (const model::StateComponent& one : model::components_in_balance(equations))
        problem.balanced.push_back(quantity(one));
    problem.integrated.shortest = shortest_of_patterns(equations, scene.grid, degree);
    problem.sizes.assign(problem.components.size(), 0.0);
    problem.start = [scene, equations](const numerics::System& linear, Threads& threads) {
        return model::start_spectra(io::start_of(scene), equations, linear, static_cast<std::uint64_t>(scene.run.seed),
                                    threads);
    };
    problem.observer = [equations, degree, grid = scene.grid, watches = scene.time.max_error > 0.0](Threads& threads,
                                                                                                    bool whole) {
        const auto own =
            std::make_shared<Observer>(measure::make_model_setting(equations, grid, degree, watches && whole), threads);
        return field_observer(measure::model_observables(own->setting), [own](const FieldState& state) {
            if (own->balanced.count() > 0) own->transform.forward(state.balanced, own->balanced);
            return measure::ModelMoment{.setting = own->setting,
                                        .state = state.spectra,
                                        .state_on_grid = state.fields,
                                        .balanced = own->balanced,
                                        .balanced_on_grid = state.balanced,
                                        .step_error = state.step_error};
        });
    };
    problem.likely_cause = [grid = scene.grid, dt = scene.time.dt](const numerics::System&, double tail) {
        return likely_cause(grid, dt, tail);
    };
    problem.term_not_finite = [](double, const numerics::Spectra&) { return std::string(); };
    return problem;
}

}  // namespace drover::run
