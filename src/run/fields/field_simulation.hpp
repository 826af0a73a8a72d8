// run/fields/field_simulation.hpp: a scene of fields as a Simulation.
#pragma once
#include <memory>

#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "numerics/steppers/step_error.hpp"
#include "run/loop/scene_support.hpp"
#include "run/loop/simulation.hpp"

namespace drover::run {

// The functions of fields for run/simulation_type.hpp, which documents them.
int choose_threads(const io::Scene& scene);
RunBytes field_bytes(const io::Scene& scene);
std::string field_size(const io::Scene& scene);
TimedScene timed_fields(const io::Scene& scene);
void check_field_start(const io::Scene& scene);

/// Its recordings have the units of the scene.  Throws an input Error for an initial file with another cell or other
/// fields.
std::unique_ptr<Simulation> make_field_simulation(const io::Scene& scene, Threads& threads,
                                                  std::span<const double> saved);

/// The scene with a step, whatever it is, and without estimates of errors: its fields at t = 0 are the same.
io::Scene start_alone(const io::Scene& scene);

/// The fields at t = 0.  Throws as make_field_simulation().
numerics::Spectra initial_fields(const io::Scene& scene, Threads& threads);

/// The frames of a run.
files::Recording frame_recording(const io::Scene& scene);

/// A step is chosen for this part of time.max_error: the estimate is within a factor of 2 to 3 of the error.
inline constexpr double choice_margin = 0.4;

/// The error of a step that drover chose is above its limit: the run must be made again with a shorter one.
class StepTooLong : public Error {
public:
    StepTooLong(const std::string& message, int needed_halvings)
        : Error(Fault::run, {}, message), halvings(needed_halvings) {}
    int halvings;  ///< that are expected to suffice to the end of the run
};

}  // namespace drover::run
