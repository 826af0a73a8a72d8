// run/trade_study.hpp: the trials of a study, axis by axis, and what they show.
#pragma once
#include "run/trade_front.hpp"
#include "run/tradeoff_options.hpp"

namespace drover::run {

/// Makes the trials, within the budget.
Findings find_tradeoff(const io::Scene& scene, const TradeoffOptions& options);

}  // namespace drover::run
