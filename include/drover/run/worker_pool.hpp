// run/worker_pool.hpp: independent jobs in child processes: one that fails takes no other with it.
#pragma once
#include <cstddef>
#include <functional>

namespace drover::run {

struct PoolOutcome {
    std::size_t done = 0;    ///< jobs that ended with status 0
    std::size_t failed = 0;  ///< jobs that ended otherwise
    bool stopped = false;    ///< a signal asked for a stop: it was passed on to the workers, which were waited for
};

/// Runs work(job) for the jobs 0 .. count - 1, `workers` at a time, each in a child process whose exit status is what work returns;
/// an exception there is told on standard error and gives 1 or 2.  ended(job, status) is called here, in order of ending.
/// The caller must have no threads.
PoolOutcome run_jobs(std::size_t count, int workers, const std::function<int(std::size_t job)>& work,
                     const std::function<void(std::size_t job, int status)>& ended);

}  // namespace drover::run
