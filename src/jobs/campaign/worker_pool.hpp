// jobs/campaign/worker_pool.hpp: independent jobs in child processes; a failed job does not affect the others.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "base/constants.hpp"

namespace drover::jobs {

/// Workers are killed when this process ends for any reason.
struct PoolOptions {
    int workers = 1;  ///< simultaneous jobs
    /// Time between a signal and the killing of workers that still run [s].
    double grace_period = infinite;
};

/// Passes a message from a worker to its parent.
using Send = std::function<void(const std::string& message)>;

/// Jobs, each in its own child process; more may become available while others run.  The caller must have no threads.
struct Jobs {
    /// The next job; empty when none is available, and called again later.
    std::function<std::optional<std::size_t>()> next;
    /// Runs in the child process and returns its exit status.  An Error of the scene, or of a machine too small for it,
    /// is reported on standard error and gives 1 or 2.  Further jobs would meet any other exception too: run_jobs
    /// starts none, stops the running ones as after a signal, and throws it as an Error.
    std::function<int(std::size_t job, const Send& send)> work;
    /// Called in the parent for each message of a job, in order, also for those of a job that ended by a signal later.
    /// An exception from it or from the next ends all workers.
    std::function<void(std::size_t job, const std::string& message)> received;
    /// Called in the parent, in the order in which jobs end.
    std::function<void(std::size_t job, int status)> ended;
    /// Called in the parent at least every 20 ms while jobs run; may be empty.
    std::function<void()> idle = {};
};
/// Returns whether a signal stopped them, which was passed on to the workers; all of them have ended.
bool run_jobs(const Jobs& jobs, const PoolOptions& options);

}  // namespace drover::jobs
