// jobs/campaign/slurm_script.cpp: a command as jobs of Slurm.
#include "jobs/campaign/slurm_script.hpp"

#include "drover/base/text.hpp"
#include "jobs/campaign/campaign.hpp"
#include "run/loop/signals.hpp"

namespace drover::jobs {

std::string slurm_script(const SlurmPlan& plan) {
    std::string command = text("drover {} {} --output {} --quiet", plan.command,
                               shell_word(std::filesystem::absolute(plan.scene).string()),
                               shell_word(std::filesystem::absolute(plan.folder).string()));
    for (const std::string& setting : plan.overrides) command += " --set " + shell_word(setting);
    for (const std::string& word : plan.options) command += " " + shell_word(word);
    if (run::max_time() > 0.0) command += text(" --max-time {:.10g}", run::max_time());
    for (const std::string& rule : stop_rules()) command += " --stop-when " + shell_word(rule);
    return text(R"(#!/bin/sh
# Runs drover {2} as {0} array tasks of Slurm, and a last job, which runs what they left and writes the result.
# Run it with sh; options are passed to sbatch, as in
#     sh {2}.sh --partition=short --time=12:00:00 --cpus-per-task=8
# Re-run it to resume after a time limit or a failure: nothing that has ended is run again, and tasks that still run
# keep what they are at.  All tasks need access to the same folder.
set -eu
command -v drover > /dev/null || {{ echo "drover is not found: add its folder to PATH" >&2; exit 2; }}
work={1}
submit() {{  # again while the controller does not answer: twice the same job does no harm
    for try in 1 2 3 4 5 6 7 8 9 10 11 12; do
        sbatch --parsable --requeue --open-mode=append "$@" && return
        sleep 5
    done
    return 1
}}
array=$(submit --job-name=drover --array=1-{0} "$@" \
    --wrap "exec $work --share \$SLURM_ARRAY_TASK_ID/{0} --workers \${{SLURM_CPUS_PER_TASK:-1}}")
submit --job-name=drover-table --dependency="afterany:${{array%%;*}}" "$@" \
    --wrap "exec $work --workers \${{SLURM_CPUS_PER_TASK:-1}}"
)",
                plan.shares, shell_word(command), plan.command);
}

}  // namespace drover::jobs
