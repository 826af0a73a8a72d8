// jobs/boundary_shares.hpp: phase boundaries whose points many processes share in a folder.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "analysis/boundary.hpp"
#include "jobs/campaign/job_options.hpp"

namespace drover::jobs {

/// The result of make_boundary, to the byte; nothing for a share, whose part is done, and after a signal.  Goes on with
/// what is in the folder.  0 workers: as many as the threads.  Throws as make_boundary, an input Error if the folder
/// holds another plane, or points of another version, and a run Error if it collects and points are missing.
std::optional<run::Result> make_boundary_in_shares(const io::Scene& scene, const JobOptions& job, Threads& threads);

/// Whether the folder has points of this plane, by this version of drover.
bool has_shares(const io::Scene& scene, const std::filesystem::path& folder);

/// One line on what all processes have done.
std::string boundary_status(const io::Scene& scene, const std::filesystem::path& folder);

}  // namespace drover::jobs
