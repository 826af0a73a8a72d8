// run/step_bias.hpp: what the time step changes in each observable of a run.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "io/scene.hpp"
#include "measure/observable.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"
#include "run/simulation.hpp"

namespace drover::run {

/// The same equations as those of a run with half of its step, on the same noise path.
struct Twin {
    std::function<void()> follow;  ///< begins anew, about the reference of the run now
    std::function<void(std::int64_t half_step, numerics::Spectra& state)> advance;
    std::function<std::vector<double>()> save;
    std::function<void(std::span<const double>)> restore;
};

numerics::StepControl control_of_twin(const io::TimeControl& time);

/// accuracy.effort, and that of the error of the fields where it is 0.
double effort_of_estimates(const io::Scene& scene);
/// The part of it for the error of the fields, which pilots need whatever it costs.  The rest is for the biases.
double effort_of_step_error(const io::Scene& scene);
/// Of a pilot.
inline constexpr double effort_of_pilots = std::numeric_limits<double>::infinity();

/// What is measured of a run of fields, whatever their equations.
struct BiasedRun {
    std::size_t values = 0;             ///< of all observables, one after another
    int components = 0;                 ///< of a state
    std::function<double()> work_done;  ///< by the run, without what estimates of errors take
    std::function<std::vector<double>(double time, const numerics::Spectra& state)> observe;
    std::function<std::optional<numerics::Spectra>()> known_error;  ///< numerics::StepError::known()
    std::function<Twin()> make_twin;
};

/// Measures the change of the observables of one run by its time step, within its share of accuracy.effort.
///
/// With noise, pieces of the run are repeated by a twin: from the state at their start, with dt/2, on the same noise
/// path.  The difference of an observable grows over its correlation time to that of the means.  A piece begins when
/// the steps so far allow it, and is an eighth of what they allow: the pieces follow from the steps alone, not from the
/// end of the run.  Without noise the observables of the fields less their estimated error (numerics::StepError) are
/// compared with those of the fields, at some of the samples.
class StepBias {
public:
    StepBias(const io::Scene& scene, BiasedRun run);
    ~StepBias();

    /// Called with the state after each step; `step`: the number of steps so far.
    void advance(std::int64_t step, const numerics::Spectra& state);

    /// One row for each piece, or each comparison; `state` is that of the run.
    static ScheduledRecording recording(const std::shared_ptr<StepBias>& bias, const numerics::Spectra& state);

    std::vector<double> save() const;
    void restore(std::span<const double> values);

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// Whether a scene can have one: else why not, for people.
std::string why_no_step_bias(const io::Scene& scene);

/// The group of an archive that holds its rows.
inline constexpr const char* step_bias_group = "/step_bias";

}  // namespace drover::run
