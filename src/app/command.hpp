// app/command.hpp: options and output that several commands share; each command adds itself to the command line.
#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "files/archive.hpp"
#include "io/scene.hpp"
#include "jobs/campaign/job_options.hpp"
#include "run/loop/signals.hpp"
#include "run/report/report.hpp"
#include "run/result.hpp"
#include "run/run_scene.hpp"

namespace drover::app {

/// Runs the chosen command; returns the exit status.
using Action = std::function<int()>;

/// The commands in the order of drover --help; each is one file, with the function add_<command>().
// clang-format off
#define DROVER_COMMANDS(X) \
    X(run) X(restart) X(sweep) X(calibrate) X(stability) X(boundary) X(states) X(tradeoff) X(check) \
    X(explain) X(info) X(diff) X(fit) X(export) X(film) X(serve) X(schema)
// clang-format on
#define DROVER_DECLARE(command) void add_##command(CLI::App& program, Action& action);
DROVER_COMMANDS(DROVER_DECLARE)
#undef DROVER_DECLARE

/// Runs `work` with the options if the command is the chosen one.
template <class Options, class Work>
void when_chosen(CLI::App& command, Action& action, const std::shared_ptr<Options>& options, Work work) {
    command.callback(
        [options, &action, work] { action = [options, work] { return static_cast<int>(work(*options)); }; });
}

/// Each exit status with its meaning.
std::span<const std::pair<int, const char*>> exit_statuses();

struct SceneOptions {
    std::string scene;
    std::vector<std::string> overrides;
    std::string output;
    int threads = 0;
};
/// Rejects an empty name of a file, such as that of a variable of the shell that is not set.
CLI::Validator a_name();
/// The positional SCENE and --set.
void add_scene_options(CLI::App& command, SceneOptions& options);
void add_set_option(CLI::App& command, SceneOptions& options);
/// --output and --threads, which override keys of the scene.
void add_output_options(CLI::App& command, SceneOptions& options);
void add_threads(CLI::App& command, int& threads);
/// An option that overrides a key of the scene.
template <class Value>
CLI::Option* add_key(CLI::App& command, SceneOptions& options, const char* option, const char* key,
                     const std::string& help) {
    return command.add_option_function<Value>(
        option, [&options, key](const Value& value) { options.overrides.push_back(key + ("=" + toml_text(value))); },
        help);
}

/// Of a command whose work processes share in a folder.
struct JobCommand : SceneOptions {
    std::string share;  ///< "2/8"; "": plain
    int slurm = 0;      ///< shares of the script; 0: no script
    int workers = 0;
    bool collect = false, status = false, json = false, quiet = false;
};
/// What the help says of them; work: "trials".
struct JobHelp {
    std::string output, work, workers, collect, status, slurm;
    std::string json = "Print the table as JSON", quiet = "Print no log";
};
/// --output, --workers, --share, --collect, --status and --slurm, of which one may be given, --json and --quiet.
void add_job_options(CLI::App& command, JobCommand& options, const JobHelp& help);
/// The folder is --output, or the name of the scene with an ending, ".sweep".
jobs::JobOptions job_of(const JobCommand& options, const char* ending);

/// What --status and --slurm print.
struct JobAnswers {
    std::function<std::string()> status;
    std::function<void()> check;              ///< throws before there is a script for what cannot run
    std::vector<std::string> overrides = {};  ///< "section.key=value"
    std::vector<std::string> words = {};      ///< further ones of the command
};
/// Whether one of them was given, and answered.
bool answers(const JobCommand& options, const char* command, const std::filesystem::path& folder,
             const JobAnswers& how);

/// Says that a signal stopped the command and how to resume it; `kept` joins the two.  Returns the exit status.
int print_stopped(const char* kept);

/// --max-time, of a command that can be resumed.
void add_max_time(CLI::App& command);
/// The same and --stop-when, of a command with many jobs.
void add_stop_options(CLI::App& command);
/// Of a command with a result.
struct ResultOptions : SceneOptions {
    bool json = false, overwrite = false;
};
/// --output, --threads, --overwrite and --json.
void add_result_options(CLI::App& command, ResultOptions& options, const std::string& output_help);
/// The scene with all its overrides.
io::Scene scene_of(const SceneOptions& options);

/// To standard output, without control characters: for all texts with names of files, or of files.
void print(const std::string& words);

/// To standard output, in ASCII.  Texts of a file that are not UTF-8 get replacement characters.
void print_json(const nlohmann::json& value);

/// How a result is printed and stored.
struct ResultOutput {
    std::string file;      ///< archive to write as well; "": none
    std::string what;      ///< of its title: "stability", "boundary"
    std::string contents;  ///< of the file, in one line for people
    bool json = false, overwrite = false;
};
template <class Options>
ResultOutput output_of(const Options& options, const char* what, const char* contents) {
    return {options.output, what, contents, options.json, options.overwrite};
}
/// Throws, before anything is computed, unless the archive can be written.  input: the file that the command is about.
void check_output(const ResultOutput& output, const std::string& input, const io::Scene& scene);
/// Prints as text or JSON, writes the archive with its provenance, and returns the exit status.  Throws as
/// files::Archive::create.
int print_result(const run::Result& result, const ResultOutput& output, const io::Scene& scene, int threads);

/// Becomes `python3 -m drover.PART ARGUMENTS`, which carries out `command`, with the package beside the program; does
/// not return then.  Throws an input Error where there is no Python.  What the part imports and is missing is named.
int run_python_package(const std::string& command, const std::string& part, const std::vector<std::string>& arguments);

/// Prints the outcome and the results of a run; returns its exit status.
int print_outcome(const run::RunOutcome& outcome, bool json);

}  // namespace drover::app
