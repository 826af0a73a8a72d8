// app/states.cpp: drover states SCENE --wave x.
#include "analysis/states.hpp"

#include "app/command.hpp"

namespace drover::app {

void add_states(CLI::App& program, Action& action) {
    struct Options : ResultOptions {
        std::string wave;
        double speed = 0.0, settle = 0.0;
        analysis::StatesOptions states;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand(
        "states", "Travelling and standing states of a scene, stable or not: profile, speed, densities, stability");
    add_scene_options(*command, *options);
    command->add_option("--wave", options->wave, "Axis along which the state varies and travels: x")
        ->required()
        ->check(CLI::IsMember({"x"}));
    const CLI::Option* speed =
        command->add_option("--speed", options->speed, "Guess of its velocity along x [mm/s]")->type_name("NUMBER");
    const CLI::Option* settle =
        command
            ->add_option(
                "--settle", options->settle,
                "Let the guess evolve for this time first [s]; else 0 and, if no state is found, up to time.end")
            ->check(CLI::Range(0.0, 1e9));
    CLI::Option* follow =
        command
            ->add_option("--follow", options->states.follow,
                         "Follow the state past folds while a number of the model goes from its value to this one")
            ->type_name("KEY=VALUE");
    command->add_option("--points", options->states.max_points, "Largest number of states along the curve")
        ->check(CLI::Range(2, 10000))
        ->needs(follow);
    add_result_options(*command, *options, "Also write the states to this archive (HDF5)");
    command->callback([options, speed, settle, &action] {
        if (speed->count() > 0) options->states.speed = options->speed;
        if (settle->count() > 0) options->states.settle = options->settle;
        action = [options] {
            const io::Scene scene = io::read_scene(options->scene, options->overrides);
            io::require_grid(scene, "states");
            Threads threads(options->threads > 0 ? options->threads : 1);
            const ResultOutput output = output_of(*options, "states", "the fields of each state as a frame");
            check_output(output, options->scene, scene);
            return print_result(analysis::make_states(scene, options->states, threads), output, scene, threads.count());
        };
    });
}

}  // namespace drover::app
