// app/run.cpp: drover run SCENE.
#include "app/command.hpp"
#include "base/log.hpp"
#include "jobs/tradeoff/tradeoff.hpp"

namespace drover::app {

void add_run(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        std::vector<std::string> accuracy;
        bool overwrite = false, json = false, quiet = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand("run", "Run a scene from t = 0 and print its results");
    add_scene_options(*command, *options);
    add_output_options(*command, *options);
    command
        ->add_option(
            "--accuracy", options->accuracy,
            "Find the cheapest run with these errors first, as drover tradeoff does, by trials of at most a tenth "
            "of the run: polar_order=1%; repeatable")
        ->type_name("OBSERVABLE=ERROR");
    command->add_flag("--overwrite", options->overwrite, "Replace an existing archive");
    add_max_time(*command);
    command->add_flag("--json", options->json, "Print the results as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log and no progress");
    when_chosen(*command, action, options, [](const Options& given) {
        const run::RunOptions how{.overwrite = given.overwrite, .quiet = given.quiet};
        io::Scene scene = scene_of(given);
        if (!given.accuracy.empty()) {
            const std::vector<jobs::AccuracyTarget> targets = jobs::parse_accuracy_targets(given.accuracy);
            run::check_needs(scene, how);  // before the trials
            const auto found = jobs::with_accuracy(scene, targets, given.quiet);
            if (!found) {
                log_information("stopped by {} during the trials, which are kept; re-run the same command to resume",
                                run::stop_reason(run::stop_signal()));
                return static_cast<int>(run::exit_stopped);
            }
            scene = *found;
        }
        return print_outcome(run::run_scene(scene, how), given.json);
    });
}

}  // namespace drover::app
