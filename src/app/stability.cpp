// app/stability.cpp: drover stability SCENE.
#include "analysis/stability.hpp"

#include "app/command.hpp"
#include "run/fields/field_simulation.hpp"

namespace drover::app {

void add_stability(CLI::App& program, Action& action) {
    const auto options = std::make_shared<ResultOptions>();
    CLI::App* command = program.add_subcommand(
        "stability",
        "Linear stability of the uniform states: instabilities, sound and damping by angle, structure factors");
    add_scene_options(*command, *options);
    add_result_options(*command, *options,
                       "Also write the result, with maps over wavenumber and angle, to this archive (HDF5)");
    when_chosen(*command, action, options, [](const ResultOptions& given) {
        const io::Scene scene = io::read_scene(given.scene, given.overrides);
        io::require_grid(scene, "stability");
        Threads threads(given.threads > 0 ? given.threads : run::choose_threads(scene));
        const bool with_maps = !given.output.empty();
        const ResultOutput output = output_of(given, "stability", "instabilities, and maps over wavenumber and angle");
        check_output(output, given.scene, scene);
        return print_result(analysis::make_stability(scene, with_maps ? &threads : nullptr), output, scene,
                            threads.count());
    });
}

}  // namespace drover::app
