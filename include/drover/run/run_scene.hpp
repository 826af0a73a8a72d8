// run/run_scene.hpp: a scene from its start, or from a checkpoint, to its end.
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "drover/io/scene.hpp"
#include "drover/run/loop.hpp"

namespace drover::run {

struct RunOptions {
    bool overwrite = false;  ///< replace an archive that exists
    bool quiet = false;      ///< no log, no progress
};

struct RunOutcome {
    LoopOutcome loop;
    std::filesystem::path archive;
    double archive_megabytes = 0.0;
    double checkpoint_time = 0.0;  ///< that it can be restarted from [s]
};

/// Where a scene's archive goes.
std::filesystem::path archive_path(const io::Scene& scene);

/// Whether there is something to restart it from.
bool has_checkpoint(const std::filesystem::path& archive);

/// What a scene asks of a machine, before any of it is taken.
struct Needs {
    double memory_bytes = 0.0;
    double disk_bytes = 0.0;  ///< before compression
    double memory_free = 0.0, disk_free = 0.0;
};
Needs needs_of(const io::Scene& scene);

/// Throws an input Error when the scene needs more memory than there is, its archive exists or cannot be written.
void check_needs(const io::Scene& scene, const RunOptions& options);

/// Runs a scene from t = 0.  Nothing is left behind when it cannot start.
RunOutcome run_scene(const io::Scene& scene, const RunOptions& options);

/// Goes on from the newest whole checkpoint of an archive.  Overrides may change time.end, output.checkpoint_minutes and
/// run.threads; another key is refused, since it would be another run.
RunOutcome restart_run(const std::filesystem::path& archive, std::span<const std::string> overrides,
                       const RunOptions& options);

}  // namespace drover::run
