// jobs/sweep_results.hpp: the table of a sweep from the results of its runs.
#pragma once
#include <map>

#include "jobs/run_record.hpp"
#include "jobs/sweep_table.hpp"

namespace drover::jobs {

/// Of the runs that have ended, by name.
SweepTable sweep_table(const SweepLayout& layout, const std::map<std::string, RunResults>& results);

}  // namespace drover::jobs
