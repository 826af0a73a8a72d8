// run/run_scene.hpp: running a scene from its start or from a checkpoint, into an archive or in memory.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "io/scene.hpp"
#include "run/loop/simulation.hpp"
#include "run/report/report.hpp"

namespace drover::run {

struct RunOptions {
    bool overwrite = false;  ///< replace an existing archive
    bool quiet = false;      ///< no log, no progress
    bool rounds_up = false;  ///< all steps round up, not to the nearest, to see what rounding does; one thread
    physics::TermFunctions functions = {};  ///< of a restart: those that the terms of its scene name
};

struct RunOutcome {
    LoopOutcome loop;
    std::filesystem::path archive;
    double archive_megabytes = 0.0;
    double checkpoint_time = 0.0;  ///< of the last checkpoint [s]
    std::optional<Report> report;  ///< of a run that reached its end
};

/// output.file, or the name of the scene with .h5.
std::filesystem::path archive_path(const io::Scene& scene);

/// Memory and disk that a scene needs, and what is free [bytes].
struct Needs {
    double memory_bytes = 0.0;
    double disk_bytes = 0.0;  ///< before compression
    double memory_free = 0.0, disk_free = 0.0;
};
Needs needs_of(const io::Scene& scene);
/// Where the archive may need more than is free; no error, as most archives are compressed.
std::optional<std::string> disk_warning(const Needs& needs);

/// Expected wall time of a scene on this machine [s].
struct ExpectedTime {
    double step = 0.0;    ///< of one step
    double total = 0.0;   ///< of all steps, samples and frames
    bool scaled = false;  ///< measured on a smaller grid or cell, and scaled by the work per step
};

/// Times a few steps, a sample and a frame for at most half a second; from a uniform state where the initial state is
/// costly.  Empty when the scene cannot be stepped.
std::optional<ExpectedTime> expected_time(const io::Scene& scene);

/// Throws an input Error when memory is insufficient.
void check_memory(const io::Scene& scene);

/// The same, and when the archive exists or cannot be written.
void check_needs(const io::Scene& scene, const RunOptions& options);

/// Runs a scene from t = 0.  Leaves no files when it cannot start.
RunOutcome run_scene(const io::Scene& scene, const RunOptions& options);

/// Resumes from the latest valid checkpoint of an archive; a run that was killed before it wrote one starts anew.
/// Overrides may change time.end, output.checkpoint_minutes and run.threads only: other keys would make it a different
/// run.
RunOutcome restart_run(const std::filesystem::path& archive, std::span<const std::string> overrides,
                       const RunOptions& options);

/// The report, without linear theory, that the archive of a run from t = 0 would give, to the last bit; no file is
/// written.  Nothing when a signal stopped it.  Throws as run_scene.
std::optional<Report> run_in_memory(const io::Scene& scene);

}  // namespace drover::run
