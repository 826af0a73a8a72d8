// app/explain.cpp: drover explain SCENE.
#include "app/command.hpp"
#include "report/shown.hpp"
#include "run/step_choice.hpp"

namespace drover::app {

void add_explain(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand(
        "explain", "Describe a scene and its cost: fields and terms, or particles; memory, disk, wall time");
    add_scene_options(*command, *options);
    add_output_options(*command, *options);
    command->add_flag("--json", options->json, "Print as JSON");
    when_chosen(*command, action, options, [](const Options& given) {
        const io::Scene scene = run::with_chosen_step(scene_of(given), given.json);
        return print_result(report::explain(scene), {.json = given.json}, scene, 1);
    });
}

}  // namespace drover::app
