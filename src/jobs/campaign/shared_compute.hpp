// jobs/campaign/shared_compute.hpp: numbers that all processes of a campaign compute together, loop after loop.
#pragma once
#include "base/compute_all.hpp"
#include "jobs/campaign/campaign.hpp"

namespace drover::jobs {

/// What a loop throws that does not end in this process: a signal came, or numbers are missing and it only collects.
struct Interrupted {};

/// The loops of a calculation whose course depends on their numbers alone: every process goes through the same loops,
/// and computes of each what no other has.  Numbers of a loop that is over are not computed again, so that a process
/// that starts later, or anew, goes through all that is known in a moment.  Calls throw Interrupted, and a run Error
/// for numbers that failed.
ComputeAll shared_compute(CampaignOptions options);

}  // namespace drover::jobs
