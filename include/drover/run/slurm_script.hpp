// run/slurm_script.hpp: a sweep or a calibration as jobs of Slurm.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace drover::run {

struct SlurmPlan {
    std::string command;                 ///< "sweep"
    std::filesystem::path scene;         ///< file
    std::vector<std::string> overrides;  ///< "section.key=value"
    std::filesystem::path folder;
    int shares = 1;
    std::string last = {};  ///< of the last job: a further word of the command
};

/// A shell script that submits the shares as an array, and a job that finishes what they left and makes the table.
std::string slurm_script(const SlurmPlan& plan);

}  // namespace drover::run
