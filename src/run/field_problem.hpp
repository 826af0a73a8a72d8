// run/field_problem.hpp: what a run of fields needs of its equations, whatever they are.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "files/archive.hpp"
#include "io/scene.hpp"
#include "measure/field_setting.hpp"
#include "measure/observable.hpp"
#include "model/field_evolution.hpp"

namespace drover::run {

/// A state as observables need it.
struct FieldState {
    double time = 0.0;
    const numerics::Spectra& spectra;
    const numerics::Fields& fields;    ///< the same on the grid
    const numerics::Fields& balanced;  ///< of FieldProblem::balanced, on the grid
    double step_error = 0.0;           ///< so far
};

/// The observables of fields.
struct FieldObserver {
    std::vector<measure::Axis> axes;
    std::vector<files::Quantity> quantities;
    std::size_t values = 0;  ///< of all quantities
    std::shared_ptr<const measure::FieldSetting> setting;
    std::function<std::vector<std::vector<double>>(const FieldState&)> measure;
};
FieldObserver field_observer(const io::Scene& scene, const model::Integrated& what, Threads& threads);
/// The same without what a run alone can tell, its energy budget and its step error.
FieldObserver observer_of_state(const FieldObserver& whole, Threads& threads);

struct FieldProblem {
    model::Integrated integrated;
    std::vector<files::Quantity> components;  ///< of a state, as frames have them
    std::vector<files::Quantity> balanced;    ///< components in balance that frames have, too
    std::vector<double> sizes;                ///< of each component: its size in the model; 0: unknown
    /// The same, where uniform stationary states are larger theirs: takes a search.
    std::function<std::vector<double>()> searched_sizes;
    /// Why a run may have diverged, for people.  tail: the part of the variance of the field in its shortest waves.
    std::function<std::string(const numerics::System& linear, double tail)> likely_cause;
    /// The text of a term that is not finite somewhere in a state; "" if all are.
    std::function<std::string(double t, const numerics::Spectra& state)> term_not_finite;
};

/// Throws an input Error for equations that a run cannot integrate.
FieldProblem field_problem(const io::Scene& scene);
/// Sets what follows `balanced`, and Integrated::shortest.
void complete_problem(const io::Scene& scene, FieldProblem& problem);

}  // namespace drover::run
