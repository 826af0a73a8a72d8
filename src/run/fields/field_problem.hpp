// run/fields/field_problem.hpp: what a run of fields needs of its equations, whatever they are.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "drover/numerics/transform.hpp"
#include "files/archive.hpp"
#include "io/scene.hpp"
#include "measure/fields.hpp"
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
class FieldObserver {
public:
    FieldObserver(measure::FieldSetting setting, Threads& threads, std::unique_ptr<model::EnergyMeter> energy = {});

    const measure::FieldSetting& setting() const { return setting_; }
    std::vector<measure::Axis> axes() const { return measure::axes_of(rows_); }
    std::vector<files::Quantity> quantities() const;
    std::size_t values() const;  ///< of all quantities
    std::vector<std::vector<double>> measure(const FieldState& state);

private:
    measure::FieldSetting setting_;
    numerics::Transform transform_;
    numerics::Spectra balanced_;
    measure::Observables<measure::FieldMoment> rows_;
    std::unique_ptr<model::EnergyMeter> energy_;
};
using SharedObserver = std::shared_ptr<FieldObserver>;
/// Throws an input Error where two results of a model of one's own would have one name in archives.
void check_result_names(const io::Scene& scene);

SharedObserver field_observer(const io::Scene& scene, const model::Integrated& what, Threads& threads);
/// The same without what a run alone can tell, its energy budget and its step error.
SharedObserver observer_of_state(const SharedObserver& whole, Threads& threads);

struct FieldProblem {
    model::Integrated integrated;
    std::vector<files::Quantity> components;  ///< of a state, as frames have them
    std::vector<files::Quantity> balanced;    ///< components in balance that frames have, too
    std::vector<double> sizes;                ///< of each component: its size in the model; 0: unknown
};

/// Throws an input Error for equations that a run cannot integrate.
FieldProblem field_problem(const io::Scene& scene);
/// Sets the sizes, and Integrated::shortest.
void complete_problem(const io::Scene& scene, FieldProblem& problem);

/// The sizes of components, where uniform stationary states are larger theirs: takes a search.
std::vector<double> searched_sizes(const io::Scene& scene, const model::Integrated& what);
/// Why a run may have diverged, for people.  tail: the part of the variance of the field in its shortest waves.
std::string likely_cause(const io::Scene& scene, const model::Equations& equations, const numerics::System& linear,
                         double tail);
/// The text of a term that is not finite somewhere in a state; "" if all are.
std::string term_not_finite(const io::Scene& scene, const model::Integrated& what, double t,
                            const numerics::Spectra& state);

/// Coordinates of the points of a field along an axis [mm].
std::vector<double> cell_corners(int count, double side);
/// The frame initial.frame of the archive initial.file.  On other points in the same cell it is taken by the modes that
/// both grids have, and this is logged.  degree: that decides which modes the run keeps.  Throws an input Error at
/// these keys unless it has these fields in these units, in the cell of the scene, with finite values.
numerics::Fields frame_of_file(const io::Scene& scene, const std::vector<files::Quantity>& fields, int degree);

/// Finite, and small enough that a sum over so many modes is finite too.  False for NaN.
bool is_finite(numerics::Complex value, std::size_t modes);
/// The fields in balance with a state, on the grid.
void find_balanced(const model::FieldEvolution& evolution, double time, const numerics::Spectra& state,
                   numerics::Fields& to);

}  // namespace drover::run
