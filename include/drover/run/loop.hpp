// run/loop.hpp: the one loop: step, observe, archive, checkpoint, stop on a signal, tell the progress.
#pragma once
#include <filesystem>
#include <string>

#include "drover/files/archive.hpp"
#include "drover/run/simulation.hpp"

namespace drover::run {

struct LoopFiles {
    std::filesystem::path archive;
    std::string scene;  ///< resolved text, for the checkpoints
    double checkpoint_minutes = 5.0;
};

struct LoopOutcome {
    std::int64_t step = 0;      ///< reached
    int signal = 0;             ///< that stopped it; 0: it ran to the end
    double wall_seconds = 0.0;  ///< of stepping, observing and writing
};

/// Runs a simulation that stands at step `first` to its end.  Into an archive without rows the first ones and a checkpoint are
/// written, so that there is always one to restart from.  At the end or on a signal: rows committed, checkpoint written.
/// Throws run Errors (blow-up, full disk); what was committed stays.
LoopOutcome run_loop(Simulation& simulation, std::int64_t first, files::Archive& archive, const LoopFiles& files,
                     bool quiet);

}  // namespace drover::run
