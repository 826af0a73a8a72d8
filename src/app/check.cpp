// app/check.cpp: drover check SCENE.
#include <cstdio>
#include <memory>

#include "analysis/boundary.hpp"
#include "app/command.hpp"
#include "base/log.hpp"
#include "jobs/calibration.hpp"
#include "jobs/sweep.hpp"
#include "run/simulation_type.hpp"

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
    command->callback([options, &action] {
        action = [options] {
            const io::Scene scene = scene_of(*options);
            run::check_needs(scene, {.overwrite = true, .quiet = true});
            if (!scene.sweep.vary.empty()) jobs::plan_sweep(scene);
            if (!scene.calibration.bead_area_fractions.empty()) jobs::plan_calibration(scene);
            analysis::check_boundary(scene);
            if (options->resolved) std::fputs(io::resolved_text(scene).c_str(), stdout);
            else print(options->scene + ": valid\n");
            for (const std::string& warning : run::simulation_type_of(scene).warnings(scene))
                log_warning("{}", warning);
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
