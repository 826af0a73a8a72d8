// app/tradeoff.cpp: drover tradeoff SCENE --want NAME=ERROR --budget TIME.
#include "jobs/tradeoff.hpp"

#include <memory>

#include "app/command.hpp"
#include "base/duration.hpp"
#include "base/log.hpp"
#include "jobs/slurm_script.hpp"

namespace drover::app {

void add_tradeoff(CLI::App& program, Action& action) {
    struct Options : SceneOptions, ShareOptions {
        std::vector<std::string> targets;
        std::string budget = "20min";
        int workers = 0;
        bool json = false, quiet = false;
    };
    const auto options = std::make_shared<Options>();
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
    command->add_option("-o,--output", options->output,
                        "Folder of the trials; default: the name of the scene with .tradeoff");
    command->add_option("--workers", options->workers, "Number of simultaneous trials")->check(CLI::Range(1, 1024));
    add_share_options(*command, *options,
                      {.work = "trials",
                       .collect = "Run no trials: the result of those that have ended",
                       .status = "Print how far all processes have come: trials done, failed and running, and their "
                                 "core time",
                       .slurm = "Print a script that runs N shares on Slurm, and then the result"});
    add_stop_options(*command);
    command->add_flag("--json", options->json, "Print the result as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log");
    command->callback([options, &action] {
        action = [options] {
            jobs::TradeoffOptions study;
            study.budget = study.run_budget = seconds_of(options->budget, "--budget");
            study.targets = jobs::parse_accuracy_targets(options->targets);
            const io::Scene scene = io::read_scene(options->scene, options->overrides);
            study.folder = jobs_output(*options, ".tradeoff");
            study.workers = options->workers;
            study.quiet = options->quiet;
            study.collect = options->collect;
            study.share = share_of(*options);
            require(!options->json || options->share.empty(), {},
                    "--json with --share, which prints no result; give --json to --collect");
            if (options->status) {
                print(jobs::tradeoff_status(scene, study.folder) + "\n");
                return int{run::exit_done};
            }
            if (options->slurm > 0) {
                std::vector<std::string> words{"--budget", options->budget};
                for (const std::string& target : options->targets) words.insert(words.end(), {"--want", target});
                print(jobs::slurm_script({.command = "tradeoff",
                                          .scene = options->scene,
                                          .overrides = options->overrides,
                                          .folder = study.folder,
                                          .shares = options->slurm,
                                          .options = words}));
                return int{run::exit_done};
            }
            const jobs::Tradeoff found = jobs::study_tradeoff(scene, study);
            if (found.stopped) {
                log_information("stopped by {}; every trial is kept: re-run the same command to resume",
                                run::stop_reason(run::stop_signal()));
                return int{run::exit_stopped};
            }
            if (!options->share.empty()) return int{run::exit_done};
            print_result(found.result, {.json = options->json}, scene, 1);
            if (!found.recommended) {
                if (options->json) std::fprintf(stderr, "%s\n", printable(found.why_none).c_str());
                return int{run::exit_run_failed};
            }
            if (!options->json) print((study.folder / "recommended.toml").string() + ": the recommended scene\n");
            return int{run::exit_done};
        };
    });
}

}  // namespace drover::app
