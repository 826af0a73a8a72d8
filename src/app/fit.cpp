// app/fit.cpp: drover fit ARCHIVE KEY ...
#include "analysis/wave_fit.hpp"
#include "app/command.hpp"

namespace drover::app {

void add_fit(CLI::App& program, Action& action) {
    struct Options : analysis::WaveFitOptions {
        std::string scene;
        std::vector<std::string> overrides;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("fit",
                               "Coefficients of the field equations from the waves of a run of fields or particles");
    command->add_option("archive", options->archive, "Archive of a run, such as isotropic.h5")->required();
    command
        ->add_option(
            "keys", options->keys,
            "Numbers of the model to fit, such as relaxation.rate driving.strength; the others keep their values, "
            "but the noise is free unless one of its strengths is fitted")
        ->required();
    command->add_option("--scene", options->scene,
                        "Scene of fields with the equations and starting values; default: that of the archive");
    command->add_option("--set", options->overrides, "Override a key of that scene, section.key=value; repeatable")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    command
        ->add_option("--max-wavenumber", options->choice.max_wavenumber,
                     "Largest |q| of the waves used [1/mm]; below the smallest |q| of the cell only the means of v and "
                     "p are used; default: three times the smallest |q|")
        ->check(CLI::Range(0.0, 1e9));
    command->add_option("--from", options->choice.begin, "Use frames from this time on [s]")
        ->check(CLI::Range(0.0, 1e15));
    command->add_option("--to", options->choice.end, "Use frames up to this time [s]; default: the last")
        ->check(CLI::Range(0.0, 1e15));
    command->add_option("--every", options->choice.every, "Use every k-th frame")->check(CLI::Range(1, 1000000));
    command->add_flag("--json", options->json, "Print the result as JSON");
    when_chosen(*command, action, options, [](const Options& given) {
        const io::Scene scene = analysis::fitted_scene(given.archive, given.scene, given.overrides);
        return print_result(analysis::make_wave_fit(scene, given),
                            {.file = "", .what = "fit", .contents = "", .json = given.json}, scene, 1);
    });
}

}  // namespace drover::app
