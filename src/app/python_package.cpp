// app/python_package.cpp: commands that the Python package carries out.
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "app/command.hpp"

namespace drover::app {

namespace {
// Imports the package itself, so that a part that is missing is named with its remedy.
constexpr const char* script = R"(import importlib, sys
command, part, *arguments = sys.argv[1:]
try:
    main = importlib.import_module("drover." + part).main
    import h5py, matplotlib, xarray
except ImportError as error:
    missing = error.name or str(error)
    package = "the Python package drover" if missing.startswith("drover") else f"python3-{missing}"
    print(f"error: drover {command} needs the Python module {missing}, which {sys.executable} does not find; install "
          f"{package}, or use the Python that has it: python3 -P -m drover.{part}", file=sys.stderr)
    sys.exit(2)
sys.exit(main(arguments)))";

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

}  // namespace

int run_python_package(const std::string& command, const std::string& part, const std::vector<std::string>& arguments) {
    std::vector<std::string> words{"python3", "-B", "-c", script, command, part};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    ::setenv("PYTHONPATH", python_path().c_str(), 1);
    ::setenv("PYTHONSAFEPATH", "1", 1);            // or Python would look for modules in the current folder first
    ::execv("/usr/bin/python3", pointers.data());  // Debian's, whose modules the package uses
    ::execvp("python3", pointers.data());
    fail_input({},
               "python3 cannot be started ({}), which drover {} needs; expected Python 3 on PATH: apt-get install "
               "python3",
               std::generic_category().message(errno), command);
}

}  // namespace drover::app
