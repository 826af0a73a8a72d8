// run/loop/loop.hpp: the main loop: step, observe, archive, checkpoint, progress, stop on a signal.
#pragma once
#include <filesystem>
#include <string>

#include "files/archive.hpp"
#include "run/loop/simulation.hpp"

namespace drover::run {

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
