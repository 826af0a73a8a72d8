// run/simulation.hpp: what the loop drives: a world that advances by steps, whatever it is made of.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drover/files/archive.hpp"

namespace drover::run {

/// A recording and when it gets its rows.
struct ScheduledRecording {
    files::Recording recording;
    std::int64_t every = 0;  ///< steps between rows; 0: the first and the last step alone
    /// The arrays of one row, in the order of the recording's quantities; valid until the next call.
    std::function<std::vector<std::span<const double>>()> observe;
};

/// A world ready to run.  Its state changes by advance() and restore() alone.
struct Simulation {
    double dt = 0.0;         ///< [s]
    std::int64_t steps = 0;  ///< in all
    std::vector<ScheduledRecording> recordings;
    std::function<void(std::int64_t step)> advance;       ///< from step to step + 1
    std::function<void(std::int64_t step)> check_health;  ///< throws a run Error that says what left the finite numbers
    std::function<std::vector<double>()> save;            ///< the whole state
    std::function<void(std::span<const double>)> restore;  ///< throws an input Error if it is not of this world
    std::function<std::string()> describe;                 ///< how it went, for people; "" when there is nothing to say
    std::int64_t health_every = 8;  ///< steps between health checks: a blow-up is found within ten steps
    int threads = 1;
};

/// Rows that a recording has once `step` is reached, of those on its schedule.  The last row of a recording with every = 0, and
/// one at the end that is off the schedule, are not on it.
std::size_t scheduled_rows(const ScheduledRecording& recording, std::int64_t step);

}  // namespace drover::run
