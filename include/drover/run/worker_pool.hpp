// run/worker_pool.hpp: independent jobs in child processes: one that fails takes no other with it.
#pragma once
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>

namespace drover::run {

struct PoolOutcome {
    std::size_t done = 0;    ///< jobs that ended with status 0
    std::size_t failed = 0;  ///< jobs that ended otherwise
    bool stopped = false;    ///< a signal asked for a stop: it was passed on to the workers, which were waited for
};

struct PoolOptions {
    int workers = 1;  ///< at a time
    /// Whether workers end with this process, however it ends; else they go on to the end of their jobs.
    bool bound = false;
    /// After a signal, how long workers may go on before they are ended [s].
    double patience = std::numeric_limits<double>::infinity();
};

/// Jobs that become known while others run, each in a child process of its own.  The caller must have no threads.
struct Jobs {
    /// The number of the next job; nothing when none is known now, which is asked again whenever one has ended.
    std::function<std::optional<std::size_t>()> next;
    /// In the child process, whose exit status is what it returns; `result` is handed to the caller.  An exception is told on standard error and
    /// gives 1 or 2.
    std::function<int(std::size_t job, std::string& result)> work;
    /// In the caller, in order of ending.  An exception from it ends all workers.
    std::function<void(std::size_t job, int status, const std::string& result)> ended;
};
PoolOutcome run_jobs(const Jobs& jobs, const PoolOptions& options);

/// The jobs 0 .. count - 1, without results.
PoolOutcome run_jobs(std::size_t count, int workers, const std::function<int(std::size_t job)>& work,
                     const std::function<void(std::size_t job, int status)>& ended);

}  // namespace drover::run
