// jobs/sweep/sweep.hpp: many runs of one scene, over a grid of parameters, seeds or a ramp, and their table.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "jobs/campaign/job_options.hpp"
#include "jobs/sweep/sweep_plan.hpp"

namespace drover::jobs {

/// Throws an input Error, at the place of sweep.vary, for a text that is not "key = a, b, c" or "key = a:b:n", a
/// ramp of no key, or a value that the scene does not allow.
SweepLayout plan_sweep(const io::Scene& scene);

struct SweepOutcome {
    std::optional<SweepTable> table;  ///< not for a share, unless it was the last
    std::size_t runs = 0, already_done = 0, failed = 0, missing = 0;
    bool stopped = false;
    std::vector<std::string> failures = {};  ///< why: "point-0000-seed-7: ..."
};

/// Runs what is not finished in `folder`, beside any number of other processes that do the same: call it again to
/// resume.  Writes table.csv there, whose bytes depend on the scene alone.  Throws an input Error if the folder holds
/// another sweep.
SweepOutcome run_sweep(const io::Scene& scene, const JobOptions& options);

/// One line on what all processes of a sweep have done.
std::string sweep_status(const io::Scene& scene, const std::filesystem::path& folder);

}  // namespace drover::jobs
