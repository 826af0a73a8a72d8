// run/slurm_script.cpp: a calibration as jobs of Slurm.
#include "drover/run/slurm_script.hpp"

#include "drover/base/text.hpp"

namespace drover::run {

std::string slurm_script(const SlurmPlan& plan) {
    std::string command =
        text("drover calibrate {} --output {} --quiet", shell_word(std::filesystem::absolute(plan.scene).string()),
             shell_word(std::filesystem::absolute(plan.folder).string()));
    for (const std::string& setting : plan.overrides) command += " --set " + shell_word(setting);
    return text(R"(#!/bin/sh
# Measures the coefficients of a scene as {0} array tasks of Slurm and makes their table.
# Run it with sh; options are passed to sbatch, as in
#     sh calibrate.sh --partition=short --time=12:00:00 --cpus-per-task=8
# Re-run it to resume after a time limit or a failure: no trial that has ended is run again.
# All tasks need access to the same folder.
set -eu
calibrate={1}
array=$(sbatch --parsable --job-name=drover --array=1-{0} "$@" \
    --wrap "exec $calibrate --share \$SLURM_ARRAY_TASK_ID/{0} --workers \${{SLURM_CPUS_PER_TASK:-1}}")
sbatch --parsable --job-name=drover-table --dependency="afterany:${{array%%;*}}" "$@" --wrap "exec $calibrate --collect"
)",
                plan.shares, shell_word(command));
}

}  // namespace drover::run
