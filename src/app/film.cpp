// app/film.cpp: drover film ARCHIVE: a film of a run, drawn by the Python package.
#include "app/command.hpp"

namespace drover::app {

void add_film(CLI::App& program, Action& action) {
    struct Options {
        std::string archive, output, field;
        int every = 1, rate = 0;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("film",
                               "Make a film (.mp4, .gif) of a run of fields or particles; needs python3 and ffmpeg");
    command->add_option("archive", options->archive, "Archive of a run")->required();
    command
        ->add_option("-o,--output", options->output,
                     "Film to write, such as flock.mp4 or flock.gif, which is replaced, or flock.png for a numbered "
                     "picture of each frame; default: the name of the archive with .mp4")
        ->check(a_name());
    command->add_option("--every", options->every, "Show every k-th frame, starting with the first")
        ->check(CLI::Range(1, 1000000000));
    command->add_option("--field", options->field,
                        "Of a run of fields: the field to show; default: those of its figure");
    command->add_option("--rate", options->rate, "Pictures per second; default: 25")->check(CLI::Range(1, 1000));
    when_chosen(*command, action, options, [](const Options& given) {
        std::vector<std::string> words{"--every", std::to_string(given.every)};
        if (given.rate > 0) words.insert(words.end(), {"--rate", std::to_string(given.rate)});
        if (!given.output.empty()) words.insert(words.end(), {"--output", given.output});
        if (!given.field.empty()) words.push_back("--field=" + given.field);
        words.insert(words.end(), {"--", given.archive});
        return run_python_package("film", "film", words);
    });
}

}  // namespace drover::app
