// app/check.cpp: drover check SCENE.
#include <cstdio>

#include "app/command.hpp"
#include "base/log.hpp"
#include "report/shown.hpp"

namespace drover::app {

void add_check(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        bool resolved = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("check", "Check a scene, and that this machine has the memory and disk to run it");
    add_scene_options(*command, *options);
    add_output_options(*command, *options);
    command->add_flag("--resolved", options->resolved, "Print every key with its value, as TOML");
    when_chosen(*command, action, options, [](const Options& given) {
        const io::Scene scene = scene_of(given);
        const std::vector<std::string> warnings = report::check_scene(scene);
        if (given.resolved) std::fputs(io::resolved_text(scene).c_str(), stdout);
        else print(given.scene + ": valid\n");
        for (const std::string& warning : warnings) log_warning("{}", warning);
        return run::exit_done;
    });
}

}  // namespace drover::app
