// jobs/trade_study.hpp: the trials of a study, axis by axis, and what they show.
#pragma once
#include "jobs/trade_front.hpp"
#include "jobs/tradeoff_options.hpp"

namespace drover::jobs {

/// Makes the trials, within the budget.
Findings find_tradeoff(const io::Scene& scene, const TradeoffOptions& options);

}  // namespace drover::jobs
