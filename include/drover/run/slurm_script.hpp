// run/slurm_script.hpp: a calibration as jobs of Slurm.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace drover::run {

struct SlurmPlan {
    std::filesystem::path scene;         ///< file
    std::vector<std::string> overrides;  ///< "section.key=value"
    std::filesystem::path folder;
    int shares = 1;
};

/// A shell script that submits the shares as an array, and a job that makes the table after them.
std::string slurm_script(const SlurmPlan& plan);

}  // namespace drover::run
