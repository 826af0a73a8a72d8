// app/sweep.cpp: drover sweep SCENE.
#include "drover/run/sweep.hpp"

#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/base/log.hpp"
#include "drover/run/signals.hpp"
#include "run/json.hpp"

namespace drover::app {

void add_sweep(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        std::vector<std::string> vary;
        std::string ramp;
        int seeds = 0, workers = 0;
        bool json = false, quiet = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("sweep", "Run a scene over parameters, seeds or a ramp and tabulate; re-run to resume");
    add_scene_options(*command, *options);
    command->add_option("-o,--output", options->output,
                        "Folder of the sweep; default: the name of the scene with .sweep");
    command
        ->add_option(
            "--vary", options->vary,
            "Key and values, \"relaxation.rate = 0.5, 1, 2\" or \"relaxation.rate = 0.5:2:11\" (first:last:count); "
            "repeatable")
        ->type_name("KEY=VALUES");
    command->add_option("--seeds", options->seeds, "Number of runs at each point")->check(CLI::Range(1, 1000000));
    command->add_option("--ramp", options->ramp,
                        "Start each point from the final state of the one before: none, up or up-down");
    command->add_option("--workers", options->workers, "Number of simultaneous runs")->check(CLI::Range(1, 1024));
    add_max_time(*command);
    command->add_flag("--json", options->json, "Print the table as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log");
    command->callback([options, &action] {
        action = [options] {
            std::vector<std::string> overrides = options->overrides;
            if (!options->vary.empty()) overrides.push_back("sweep.vary=" + toml_text(options->vary));
            if (!options->ramp.empty()) overrides.push_back("sweep.ramp=" + options->ramp);
            if (options->seeds > 0) overrides.push_back(text("sweep.seeds={}", options->seeds));
            if (options->workers > 0) overrides.push_back(text("sweep.workers={}", options->workers));
            const io::Scene scene = io::read_scene(options->scene, overrides);
            const std::filesystem::path folder = options->output.empty()
                                                     ? std::filesystem::path(options->scene).stem().concat(".sweep")
                                                     : std::filesystem::path(options->output);
            const run::SweepOutcome outcome = run::run_sweep(scene, folder, options->quiet);
            if (options->json) {
                print_json(run::table_json(outcome.table));
                for (const std::string& warning : outcome.table.warnings) log_warning("{}", warning);
            } else print(run::table_text(outcome.table));
            if (!options->json) print(text("\n{}: all observables\n", (folder / "table.csv").string()));
            if (outcome.stopped) {
                log_information("stopped by {} after checkpoints; re-run the same command to resume",
                                run::stop_reason(run::stop_signal()));
                return run::exit_stopped;
            }
            if (outcome.failed > 0) {
                log_warning("{} jobs failed, see above; re-run the same command to try them again", outcome.failed);
                return run::exit_run_failed;
            }
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
