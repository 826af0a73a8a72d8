// app/run.cpp: drover run SCENE.
#include <memory>

#include "command.hpp"

namespace drover::app {

void add_run(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        bool overwrite = false, json = false, quiet = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand("run", "Run a scene from t = 0 and print its results");
    add_scene_options(*command, *options);
    add_output_options(*command, *options);
    command->add_flag("--overwrite", options->overwrite, "Replace an existing archive");
    command->add_flag("--json", options->json, "Print the results as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log and no progress");
    command->callback([options, &action] {
        action = [options] {
            return print_outcome(run::run_scene(scene_of(*options),
                                                {.overwrite = options->overwrite, .quiet = options->quiet}),
                                 options->json);
        };
    });
}

}  // namespace drover::app
