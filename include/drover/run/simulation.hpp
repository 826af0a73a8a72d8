// run/simulation.hpp: the interface between the loop and a simulation of any kind.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drover/files/archive.hpp"
#include "drover/numerics/adaptive_stepper.hpp"

namespace drover::run {

/// The group of an archive that holds the observables of fields.
inline constexpr const char* field_samples_group = "/observables";

/// A recording and its schedule.
struct ScheduledRecording {
    files::Recording recording;
    std::int64_t every = 0;  ///< steps between rows; 0: only the first and the last step
    /// The arrays of one row, in the order of the recording's quantities.  They stay where they are for the life of the
    /// simulation, and hold these values until the next call or step.
    std::function<std::vector<std::span<const double>>()> observe;
    /// Whether a row is due at a step, instead of `every`.
    std::function<bool(std::int64_t step)> due = {};
};

/// A simulation ready to run.  Only advance(), restore() and accept() change its state.
struct Simulation {
    double dt = 0.0;                                       ///< [s]
    std::int64_t steps = 0;                                ///< in all
    std::vector<ScheduledRecording> recordings;            ///< the last one holds the observables
    std::function<void(std::int64_t step)> advance;        ///< from step to step + 1
    std::function<void(std::int64_t step)> check_health;   ///< throws a run Error that reports what is not finite
    std::function<std::vector<double>()> save;             ///< the complete state
    std::function<void(std::span<const double>)> restore;  ///< throws an input Error for a state of another world
    /// Takes the fields, or bodies, that the arrays of the frames now hold as the state.  Throws an input Error, and
    /// keeps the state, where they are not finite, or bodies overlap.
    std::function<void(std::int64_t step)> accept;
    std::function<numerics::StepCount()> count;  ///< of steps taken; fields only
    std::function<double()> step_error;          ///< relative, estimated so far; fields only
    std::function<std::string()> describe;       ///< statistics of the run for people; may be ""
    std::int64_t health_every = 8;               ///< steps between health checks: a blow-up is found within ten steps
    int threads = 1;
};

/// Puts a row into arrays that observe() returns, which keep their places.
std::vector<std::span<const double>> lend(std::vector<std::vector<double>>& arrays,
                                          std::vector<std::vector<double>> row);

/// Whether a row is due at a step.
inline bool is_due(const ScheduledRecording& scheduled, std::int64_t step) {
    if (scheduled.due) return scheduled.due(step);
    return scheduled.every == 0 ? step == 0 : step % scheduled.every == 0;
}

/// Number of scheduled rows of a recording up to `step`.  The last row of a recording with every = 0, and a last row
/// off the schedule, are not counted.
std::size_t scheduled_rows(const ScheduledRecording& recording, std::int64_t step);

}  // namespace drover::run
