// app/command.cpp: options and results that several commands share.
#include "app/command.hpp"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/duration.hpp"
#include "base/log.hpp"
#include "jobs/campaign/campaign.hpp"
#include "jobs/campaign/slurm_script.hpp"
#include "report/shown.hpp"

namespace drover::app {

std::span<const std::pair<int, const char*>> exit_statuses() {
    static constexpr std::array statuses{
        std::pair<int, const char*>{run::exit_done, "success"},
        std::pair<int, const char*>{run::exit_run_failed, "a run failed"},
        std::pair<int, const char*>{run::exit_bad_input, "bad input"},
        std::pair<int, const char*>{run::exit_stopped,
                                    "stopped by a signal, --max-time or --stop-when after a checkpoint"}};
    return statuses;
}

CLI::Validator a_name() {
    return {[](const std::string& word) { return word.empty() ? "is empty; expected a name" : ""; }, "", "name"};
}

void add_scene_options(CLI::App& command, SceneOptions& options) {
    command.add_option("scene", options.scene, "Scene (TOML input file; see drover schema)")->required();
    add_set_option(command, options);
}

void add_set_option(CLI::App& command, SceneOptions& options) {
    command.add_option("--set", options.overrides, "Override a key of the scene, section.key=value; repeatable")
        ->type_name("KEY=VALUE");
}

void add_output_options(CLI::App& command, SceneOptions& options) {
    command.add_option("-o,--output", options.output, "Archive to write; overrides output.file")->check(a_name());
    add_threads(command, options.threads);
}

void add_threads(CLI::App& command, int& threads) {
    command.add_option("--threads", threads, "Number of threads; overrides run.threads and does not change results")
        ->check(CLI::Range(1, 1024));
}

void add_job_options(CLI::App& command, JobCommand& options, const JobHelp& help) {
    command.add_option("-o,--output", options.output, help.output)->check(a_name());
    command.add_option("--workers", options.workers, help.workers)->check(CLI::Range(1, 1024));
    CLI::Option* share = command
                             .add_option("--share", options.share,
                                         text("One of N processes that share the {} in a common folder", help.work))
                             ->type_name("I/N");
    CLI::Option* collect = command.add_flag("--collect", options.collect, help.collect)->excludes(share);
    CLI::Option* status = command.add_flag("--status", options.status, help.status)->excludes(share)->excludes(collect);
    command.add_option("--slurm", options.slurm, help.slurm)
        ->type_name("N")
        ->check(CLI::Range(1, 100000))
        ->excludes(share)
        ->excludes(collect)
        ->excludes(status);
    command.add_flag("--json", options.json, help.json);
    command.add_flag("-q,--quiet", options.quiet, help.quiet);
}

jobs::JobOptions job_of(const JobCommand& options, const char* ending) {
    require(!options.json || options.share.empty(), {},
            "--json with --share, which prints no result; give --json to --collect");
    jobs::JobOptions job{.folder = options.output.empty() ? std::filesystem::path(options.scene).stem().concat(ending)
                                                          : std::filesystem::path(options.output),
                         .workers = options.workers,
                         .collect = options.collect,
                         .quiet = options.quiet};
    if (!options.share.empty()) job.share = jobs::read_share(options.share);
    return job;
}

bool answers(const JobCommand& options, const char* command, const std::filesystem::path& folder,
             const JobAnswers& how) {
    if (options.status) {
        print(how.status() + "\n");
    } else if (options.slurm > 0) {
        require(options.workers == 0, {},
                "--workers with --slurm, whose jobs have a worker for each core that sbatch gives them; omit it, and "
                "give --cpus-per-task={} where the script is run",
                options.workers);
        how.check();
        print(jobs::slurm_script({.command = command,
                                  .scene = options.scene,
                                  .overrides = how.overrides,
                                  .folder = folder,
                                  .shares = options.slurm,
                                  .options = how.words}));
    }
    return options.status || options.slurm > 0;
}

int print_stopped(const char* kept) {
    log_information("stopped by {}{} re-run the same command to resume", run::stop_reason(run::stop_signal()), kept);
    return run::exit_stopped;
}

void add_max_time(CLI::App& command) {
    command
        .add_option_function<std::string>(
            "--max-time", [](const std::string& time) { run::stop_after(seconds_of(time, "--max-time")); },
            "Stop in a resumable state after this time, with status 3: 3600, 90m, 2h, mm:ss, hh:mm:ss or "
            "d-hh:mm:ss")
        ->type_name("TIME");
}

void add_stop_options(CLI::App& command) {
    add_max_time(command);
    command
        .add_option_function<std::vector<std::string>>(
            "--stop-when", [](const std::vector<std::string>& rules) { jobs::set_stop_rules(rules); },
            "Stop in the same way as with --max-time when a rule is met; repeatable.  " + jobs::stop_rules_help())
        ->type_name("RULE=LIMIT");
}

void add_result_options(CLI::App& command, ResultOptions& options, const std::string& output_help) {
    CLI::Option* output = command.add_option("-o,--output", options.output, output_help)->check(a_name());
    add_threads(command, options.threads);
    command.add_flag("--overwrite", options.overwrite, "Replace an existing archive")->needs(output);
    command.add_flag("--json", options.json, "Print the result as JSON");
}

io::Scene scene_of(const SceneOptions& options) {
    std::vector<std::string> overrides = options.overrides;
    if (options.threads > 0) overrides.push_back(text("run.threads={}", options.threads));
    io::Scene scene = io::read_scene(options.scene, overrides);
    if (!options.output.empty()) {  // no override, which is TOML: the name of a file may have any bytes
        scene.output.file = options.output;
        scene.places.insert_or_assign("output.file", SourceLocation{.file = "--output " + options.output});
    }
    return scene;
}

void print(const std::string& words) { std::fputs(printable(words).c_str(), stdout); }

void print_json(const nlohmann::json& value) {
    std::puts(value.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
}

void check_output(const ResultOutput& output, const std::string& input, const io::Scene& scene) {
    if (!output.file.empty()) report::check_result_file(output.file, {input}, scene, output.overwrite);
}

int print_result(const run::Result& found, const ResultOutput& output, const io::Scene& scene, int threads) {
    const run::Result result = run::with_units(found, scene.units);
    if (!output.file.empty()) report::write_result(result, output.file, output.what, scene, threads, output.overwrite);
    if (output.json) {
        print_json(run::result_json(result));
        return run::exit_done;
    }
    print(run::result_text(result));
    if (!output.file.empty()) print(text("\n{}: {}\n", output.file, output.contents));
    return run::exit_done;
}

int print_outcome(const run::RunOutcome& outcome, bool json) {
    if (outcome.loop.signal != 0) {
        log_information("stopped by {} at step {} (t = {}) after a checkpoint; to resume: drover restart {}",
                        run::stop_reason(outcome.loop.signal), outcome.loop.step, outcome.checkpoint_time,
                        shell_word(outcome.archive.string()));
        return run::exit_stopped;
    }
    const run::Report& report = *outcome.report;
    if (json) {
        nlohmann::json result = report::json_of(report);
        result["archive"] = outcome.archive.string();
        result["steps"] = outcome.loop.step;
        result["wall_seconds"] = outcome.loop.wall_seconds;
        print_json(result);
        return run::exit_done;
    }
    print(report::text_of(report));
    print(text("\n{}: {}, {} steps in {}\n", outcome.archive.string(), bytes_text(1e6 * outcome.archive_megabytes),
               outcome.loop.step, duration_text(outcome.loop.wall_seconds)));
    return run::exit_done;
}

}  // namespace drover::app
