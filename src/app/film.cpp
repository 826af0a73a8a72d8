// app/film.cpp: drover film ARCHIVE: a film of a run, drawn by the Python package.
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "command.hpp"

namespace drover::app {

namespace {
// Imports the package itself, so that a part that is missing is named with its remedy.
constexpr const char* script = R"(import sys
try:
    from drover.film import main
    import h5py, matplotlib, xarray
except ImportError as error:
    missing = error.name or str(error)
    package = "the Python package drover" if missing.startswith("drover") else f"python3-{missing}"
    print(f"error: drover film needs the Python module {missing}, which {sys.executable} does not find; install "
          f"{package}, or draw the film with the Python that has it: python3 -P -m drover.film", file=sys.stderr)
    sys.exit(2)
sys.exit(main(sys.argv[1:])))";

/// Folders of the Python package beside the program: in a build folder, and installed below a prefix.
std::string python_path() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    std::vector<fs::path> candidates{folder / "python"};
    for (const auto& entry : fs::directory_iterator(folder.parent_path() / "lib", ignored))
        if (entry.path().filename().string().starts_with("python3"))
            candidates.push_back(entry.path() / "dist-packages");
    std::vector<std::string> path;
    for (const fs::path& candidate : candidates)
        if (fs::exists(candidate / "drover" / "film.py", ignored)) path.push_back(candidate.string());
    const char* own = std::getenv("PYTHONPATH");
    std::istringstream parts(own == nullptr ? "" : own);
    for (std::string part; std::getline(parts, part, ':');)
        if (!part.empty()) path.push_back(part);  // an empty one is the current folder
    return joined(path, ":");
}

int make_film(const std::vector<std::string>& arguments) {
    std::vector<std::string> words{"python3", "-B", "-c", script};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    ::setenv("PYTHONPATH", python_path().c_str(), 1);
    ::setenv("PYTHONSAFEPATH", "1", 1);            // or Python would look for modules in the current folder first
    ::execv("/usr/bin/python3", pointers.data());  // Debian's, whose modules the package uses
    ::execvp("python3", pointers.data());
    fail_input({},
               "python3 cannot be started ({}), which draws films; expected Python 3 on PATH: apt-get install python3",
               std::generic_category().message(errno));
}
}  // namespace

void add_film(CLI::App& program, Action& action) {
    const auto archive = std::make_shared<std::string>(), output = std::make_shared<std::string>(),
               field = std::make_shared<std::string>();
    const auto every = std::make_shared<int>(1), rate = std::make_shared<int>(25);
    CLI::App* command =
        program.add_subcommand("film", "Make a film (.mp4) of a run of fields or particles; needs python3 and ffmpeg");
    command->add_option("archive", *archive, "Archive of a run")->required();
    command->add_option("-o,--output", *output,
                        "Film to write, such as flock.mp4, which is replaced; default: the name of the archive");
    command->add_option("--every", *every, "Show every k-th frame, starting with the first")
        ->check(CLI::Range(1, 1000000000));
    command->add_option("--field", *field, "Of a scene with fields of its own: the field to show; default: all");
    command->add_option("--rate", *rate, "Pictures per second")->check(CLI::Range(1, 1000));
    command->callback([archive, output, field, every, rate, &action] {
        action = [archive, output, field, every, rate] {
            std::vector<std::string> words{"--every", std::to_string(*every), "--rate", std::to_string(*rate)};
            if (!output->empty()) words.insert(words.end(), {"--output", *output});
            if (!field->empty()) words.push_back("--field=" + *field);
            words.insert(words.end(), {"--", *archive});
            return make_film(words);
        };
    });
}

}  // namespace drover::app
