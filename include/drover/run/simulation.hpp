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

/// A recording and its schedule.
struct ScheduledRecording {
    files::Recording recording;
    std::int64_t every = 0;  ///< steps between rows; 0: only the first and the last step
    /// The arrays of one row, in the order of the recording's quantities; valid until the next call.
    std::function<std::vector<std::span<const double>>()> observe;
};

/// A simulation ready to run.  Only advance() and restore() change its state.
struct Simulation {
    double dt = 0.0;         ///< [s]
    std::int64_t steps = 0;  ///< in all
    std::vector<ScheduledRecording> recordings;
    std::function<void(std::int64_t step)> advance;        ///< from step to step + 1
    std::function<void(std::int64_t step)> check_health;   ///< throws a run Error that reports what is not finite
    std::function<std::vector<double>()> save;             ///< the complete state
    std::function<void(std::span<const double>)> restore;  ///< throws an input Error for a state of another world
    std::function<numerics::StepCount()> count;            ///< of steps taken; fields only
    std::function<double()> step_error;                    ///< relative, estimated so far; fields only
    std::function<std::string()> describe;                 ///< statistics of the run for people; may be ""
    std::int64_t health_every = 8;  ///< steps between health checks: a blow-up is found within ten steps
    int threads = 1;
};

/// Number of scheduled rows of a recording up to `step`.  The last row of a recording with every = 0, and a last row
/// off the schedule, are not counted.
std::size_t scheduled_rows(const ScheduledRecording& recording, std::int64_t step);

}  // namespace drover::run
