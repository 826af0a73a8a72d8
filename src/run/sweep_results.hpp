// run/sweep_results.hpp: the table of a sweep from the results of its runs.
#pragma once
#include <map>

#include "run/run_record.hpp"
#include "run/sweep_table.hpp"

namespace drover::run {

/// Of the runs that have ended, by name.
SweepTable sweep_table(const SweepLayout& layout, const std::map<std::string, RunResults>& results);

}  // namespace drover::run
