// jobs/calibration/calibration.hpp: assays over area fractions: trials on workers, resumable at any time, into one
// table.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "io/scene.hpp"
#include "jobs/calibration/calibration_layout.hpp"
#include "jobs/campaign/accuracy_target.hpp"
#include "run/result.hpp"

namespace drover::jobs {

struct CalibrationOutcome {
    std::size_t units = 0;          ///< measurements
    std::size_t trials = 0;         ///< run in this call
    std::size_t already = 0;        ///< trials that were present
    std::size_t failed = 0;         ///< units without a result: too many failed trials, or no finite estimate
    std::size_t unfinished = 0;     ///< units that need more trials
    std::size_t crashed = 0;        ///< of them, those that this process gave up, as a worker died in a trial
    std::size_t unmet_targets = 0;  ///< units that ended with a larger error than requested
    bool stopped = false;
    std::optional<calibrate::Table> table;  ///< not for a share, unless nothing is left to do
    std::filesystem::path file;             ///< of the table
    std::optional<run::Result> want;        ///< wanted numbers and what their errors come from
    std::size_t unmet_wants = 0;            ///< wanted numbers that did not reach their errors
};

/// Trials are spread so that the wanted numbers reach their errors soonest; without any, every assay at every point
/// reaches calibrate.relative_error.
///
/// Runs the missing trials that no other process in `folder` has.  Call it again to resume after a stop, also after
/// kill -9: completed trials are never lost.  Then writes table.h5 and table.toml there, whose bytes depend on the
/// scene and the trials alone.  The same folder accepts other goals, more points and more assays of the same scene.
/// Throws an input Error if it holds the trials of another scene.
CalibrationOutcome run_calibration(const io::Scene& scene, const TargetOptions& options);

/// One line over all processes in the folder: measurements done; trials done, failed and running, their rate and the
/// time left.  Of `options` it takes the folder, the targets and the budget.
std::string calibration_status(const io::Scene& scene, const TargetOptions& options);

}  // namespace drover::jobs
