// app/tradeoff.cpp: drover tradeoff SCENE --want NAME=ERROR --budget TIME.
#include "jobs/tradeoff/tradeoff.hpp"

#include "app/command.hpp"
#include "base/duration.hpp"

namespace drover::app {

namespace {
struct TradeoffCommand : JobCommand {
    std::vector<std::string> targets;
    std::string budget = "20min";
};

int study_scene(const TradeoffCommand& options) {
    const jobs::TargetOptions study =
        jobs::target_options(job_of(options, ".tradeoff"), options.targets, seconds_of(options.budget, "--budget"));
    const io::Scene scene = io::read_scene(options.scene, options.overrides);
    std::vector<std::string> words{"--budget", options.budget};
    for (const std::string& target : options.targets) words.insert(words.end(), {"--want", target});
    if (answers(options, "tradeoff", study.folder,
                {.status = [&] { return jobs::tradeoff_status(scene, study.folder); },
                 .check = [] {},
                 .overrides = options.overrides,
                 .words = words}))
        return run::exit_done;
    const jobs::Tradeoff found = jobs::study_tradeoff(scene, study);
    if (found.stopped) return print_stopped("; every trial is kept:");
    if (!options.share.empty()) return run::exit_done;
    print_result(found.result, {.json = options.json}, {}, 1);  // its units are those of archives, and core time
    if (!found.recommended) {
        if (options.json) std::fprintf(stderr, "%s\n", printable(found.why_none).c_str());
        return run::exit_run_failed;
    }
    if (!options.json) print((study.folder / "recommended.toml").string() + ": the recommended scene\n");
    return run::exit_done;
}
}  // namespace

void add_tradeoff(CLI::App& program, Action& action) {
    const auto options = std::make_shared<TradeoffCommand>();
    CLI::App* command = program.add_subcommand(
        "tradeoff",
        "Measure what accuracy costs on a scene, and find the cheapest run that is accurate enough; re-run to resume");
    add_scene_options(*command, *options);
    command
        ->add_option("--want", options->targets,
                     "A time mean and its error, of 95 % of all runs: polar_order=1%, polar_order=0.01, "
                     "\"structure_factor_rods(q<1)=3%\"; repeatable")
        ->required()
        ->type_name("OBSERVABLE=ERROR");
    command
        ->add_option("--budget", options->budget,
                     "Core time of the trials, and of the recommended run: 90s, 20min, 2h; default 20min")
        ->type_name("TIME");
    add_job_options(*command, *options,
                    {.output = "Folder of the trials; default: the name of the scene with .tradeoff",
                     .work = "trials",
                     .workers = "Number of simultaneous trials",
                     .collect = "Run no trials: the result of those that have ended",
                     .status = "Print how far all processes have come: trials done, failed and running, and their "
                               "core time",
                     .slurm = "Print a script that runs N shares on Slurm, and then the result",
                     .json = "Print the result as JSON"});
    add_stop_options(*command);
    when_chosen(*command, action, options, study_scene);
}

}  // namespace drover::app
