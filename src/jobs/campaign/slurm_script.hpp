// jobs/campaign/slurm_script.hpp: a command as jobs of Slurm.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace drover::jobs {

struct SlurmPlan {
    std::string command;                 ///< "sweep"
    std::filesystem::path scene;         ///< file
    std::vector<std::string> overrides;  ///< "section.key=value"
    std::filesystem::path folder;
    int shares = 1;
    std::vector<std::string> options = {};  ///< further words of the command, such as "--want", "onset=5%"
};

/// A shell script that submits the shares as an array, and a last job that runs what they left and makes the table.
std::string slurm_script(const SlurmPlan& plan);

}  // namespace drover::jobs
