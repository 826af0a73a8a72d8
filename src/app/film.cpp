// app/film.cpp: drover film ARCHIVE: a film of a run, drawn by the Python package.
#include <memory>

#include "app/command.hpp"

namespace drover::app {

void add_film(CLI::App& program, Action& action) {
    const auto archive = std::make_shared<std::string>(), output = std::make_shared<std::string>(),
               field = std::make_shared<std::string>();
    const auto every = std::make_shared<int>(1), rate = std::make_shared<int>(0);
    CLI::App* command =
        program.add_subcommand("film",
                               "Make a film (.mp4, .gif) of a run of fields or particles; needs python3 and ffmpeg");
    command->add_option("archive", *archive, "Archive of a run")->required();
    command
        ->add_option("-o,--output", *output,
                     "Film to write, such as flock.mp4 or flock.gif, which is replaced, or flock.png for a numbered "
                     "picture of each frame; default: the name of the archive with .mp4")
        ->check(a_name());
    command->add_option("--every", *every, "Show every k-th frame, starting with the first")
        ->check(CLI::Range(1, 1000000000));
    command->add_option("--field", *field, "Of a run of fields: the field to show; default: those of its figure");
    command->add_option("--rate", *rate, "Pictures per second; default: 25")->check(CLI::Range(1, 1000));
    command->callback([archive, output, field, every, rate, &action] {
        action = [archive, output, field, every, rate] {
            std::vector<std::string> words{"--every", std::to_string(*every)};
            if (*rate > 0) words.insert(words.end(), {"--rate", std::to_string(*rate)});
            if (!output->empty()) words.insert(words.end(), {"--output", *output});
            if (!field->empty()) words.push_back("--field=" + *field);
            words.insert(words.end(), {"--", *archive});
            return run_python_package("film", "film", words);
        };
    });
}

}  // namespace drover::app
