// jobs/shared_compute.hpp: numbers that all processes of a campaign compute together, loop after loop.
#pragma once
#include <memory>

#include "base/compute_all.hpp"
#include "jobs/campaign.hpp"

namespace drover::jobs {

/// What compute() throws when a loop does not end in this process: a signal came, or numbers are missing and it only
/// collects.
struct Interrupted {};

/// The loops of a calculation whose course depends on their numbers alone: every process goes through the same loops,
/// and computes of each what no other has.  Numbers of a loop that is over are not computed again, so that a process
/// that starts later, or anew, goes through all that is known in a moment.
class SharedCompute {
public:
    explicit SharedCompute(CampaignOptions options);
    ~SharedCompute();

    /// Valid as long as this object.  Calls throw Interrupted, and a run Error for numbers that failed.
    ComputeAll compute();
    std::size_t computed() const;  ///< units, in this process

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace drover::jobs
