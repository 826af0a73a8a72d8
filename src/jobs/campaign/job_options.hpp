// jobs/campaign/job_options.hpp: how a process takes part in a job, whose work any number of processes share in a
// folder.
#pragma once
#include <filesystem>
#include <string>

namespace drover::jobs {

/// One of so many processes that share the work in a folder.  They take it in small batches, each beginning elsewhere:
/// none has a fixed part.
struct Share {
    int number = 1, count = 1;
    bool is_plain() const { return count == 1; }
    /// Of so many units the one that the share takes as its i-th.
    std::size_t nth(std::size_t i, std::size_t units) const {
        return (units * static_cast<std::size_t>(number - 1) / static_cast<std::size_t>(count) + i) % units;
    }
};

/// "2/8": the second of eight.  Throws an input Error for another text.
Share read_share(const std::string& written);

struct JobOptions {
    std::filesystem::path folder;  ///< of all that has ended, which is kept: the same call again resumes
    Share share = {};
    int workers = 0;       ///< simultaneous units; 0: as the scene says, else the cores that the process may use
    bool collect = false;  ///< runs nothing: the result of what has ended
    bool quiet = false;    ///< no log
};

/// The same with workers; of_scene: what the scene says of them, 0: nothing.
JobOptions with_workers(JobOptions options, int of_scene = 0);

}  // namespace drover::jobs
