// jobs/campaign/run_record.hpp: the results of one run as the record of a campaign.
#pragma once
#include <string>
#include <vector>

#include "jobs/campaign/campaign_records.hpp"
#include "measure/summary.hpp"

namespace drover::jobs {

/// What is kept of a run: all results with their axes, and its warnings.
struct RunResults {
    std::vector<measure::SummaryRow> rows;
    std::vector<std::string> warnings;
};

/// Names, units and axes are the shared part.  Of arrays the autocorrelation times and the reasons of missing errors
/// are not kept.
UnitResult encode(const RunResults& results);

/// Throws an input Error for other bytes.
RunResults decode(const UnitResult& result);

}  // namespace drover::jobs
