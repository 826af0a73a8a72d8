// jobs/tradeoff_options.hpp: what a study of speed and accuracy is asked.
#pragma once
#include <filesystem>
#include <vector>

#include "jobs/share.hpp"
#include "jobs/wish.hpp"

namespace drover::jobs {

struct TradeoffOptions {
    std::vector<Wish> wishes;
    double budget = 0.0;           ///< core seconds of all trials
    double run_budget = 0.0;       ///< core seconds of the recommended run
    std::filesystem::path folder;  ///< of the trials, which are kept
    Share share = {};              ///< any number of processes, on any machines, may work in one folder
    int workers = 0;               ///< simultaneous trials; 0: the cores that the process may use
    bool collect = false;          ///< runs nothing: the result of the trials that have ended
    bool quiet = false;
};

}  // namespace drover::jobs
