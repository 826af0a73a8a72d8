// run/loop/simulation.hpp: the interface between the loop and a simulation of any kind, and the main loop: step,
// observe, archive, checkpoint, progress, stop on a signal.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "files/archive.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"

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

/// What a run needs [bytes].
struct RunBytes {
    double memory = 0.0;
    double disk = 0.0;  ///< for its archive, before compression
};

/// A simulation ready to run.  Only advance(), restore() and accept() change its state.
class Simulation {
public:
    Simulation(double the_dt, std::int64_t the_steps, int the_threads)
        : dt(the_dt), steps(the_steps), threads(the_threads) {}
    virtual ~Simulation() = default;
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;

    virtual void advance(std::int64_t step) = 0;        ///< from step to step + 1
    virtual void check_health(std::int64_t step) = 0;   ///< throws a run Error that reports what is not finite
    virtual std::vector<double> save() const = 0;       ///< the complete state
    virtual void restore(std::span<const double>) = 0;  ///< throws an input Error for a state of another world
    /// Takes the fields, or bodies, that the arrays of the frames now hold as the state.  Throws an input Error, and
    /// keeps the state, where they are not finite, or bodies overlap.
    virtual void accept(std::int64_t step) = 0;
    virtual std::string describe() const = 0;                        ///< statistics of the run for people; may be ""
    virtual numerics::StepCount count() const { return {}; }         ///< of steps taken; fields only
    virtual std::optional<double> step_error() const { return {}; }  ///< relative, estimated so far; fields only

    const double dt;           ///< [s]
    const std::int64_t steps;  ///< in all
    const int threads;
    RunBytes bytes;
    std::vector<ScheduledRecording> recordings;  ///< the last one holds the observables
};

/// Whether the state after so many steps is to be checked: a blow-up is found within ten steps, and is not recorded.
bool is_checked(const Simulation& simulation, std::int64_t step);

/// Arrays as an archive has them, by path.
using Arrays = std::map<std::string, files::Array>;
/// Appends the row of a recording at a time.
void append_row(const ScheduledRecording& scheduled, double time, Arrays& arrays);
/// Takes back the last of them.
void remove_last_row(const ScheduledRecording& scheduled, Arrays& arrays);

/// Puts a row into arrays that observe() returns, which keep their places.
std::vector<std::span<const double>> store_in_place(std::vector<std::vector<double>>& arrays,
                                                    std::vector<std::vector<double>> row);

/// Whether a row is due at a step.
inline bool is_due(const ScheduledRecording& scheduled, std::int64_t step) {
    if (scheduled.due) return scheduled.due(step);
    return scheduled.every == 0 ? step == 0 : step % scheduled.every == 0;
}

struct LoopFiles {
    std::filesystem::path archive;
    std::string scene;  ///< resolved text, for the checkpoints
    double checkpoint_minutes = 5.0;
    std::string run_id = {};   ///< of the archive
    std::string program = {};  ///< this drover, for the checkpoints
};

/// Time of the processor that all threads of this process have used [s].
double core_seconds();

struct LoopOutcome {
    std::int64_t first = 0;     ///< step at which it began
    std::int64_t step = 0;      ///< reached
    int signal = 0;             ///< that stopped it; 0: the run reached its end
    double wall_seconds = 0.0;  ///< of stepping, observing and writing
    double core_seconds = 0.0;  ///< of the processor, for the same
};

/// Runs a simulation from step `first`, at which it is, to its end.  Writes the first rows and a checkpoint into an
/// empty archive, so that a checkpoint always exists.  At the end and on a signal it commits all rows and writes a
/// checkpoint.  Throws run Errors (divergence, full disk); committed data remain.
LoopOutcome run_loop(Simulation& simulation, std::int64_t first, files::Archive& archive, const LoopFiles& files,
                     bool quiet);

}  // namespace drover::run
