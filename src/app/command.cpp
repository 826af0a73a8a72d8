// app/command.cpp: options and results that several commands share.
#include "command.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "drover/base/log.hpp"
#include "drover/run/kind.hpp"
#include "run/json.hpp"

namespace drover::app {

void add_scene_options(CLI::App& command, SceneOptions& options) {
    command.add_option("scene", options.scene, "Scene (TOML input file; see drover schema)")->required();
    add_set_option(command, options);
}

void add_set_option(CLI::App& command, SceneOptions& options) {
    command.add_option("--set", options.overrides, "Override a key of the scene, section.key=value; repeatable")
        ->type_name("KEY=VALUE");
}

void add_output_options(CLI::App& command, SceneOptions& options) {
    command.add_option("-o,--output", options.output, "Archive to write; overrides output.file");
    command
        .add_option("--threads", options.threads,
                    "Number of threads; overrides run.threads and does not change results")
        ->check(CLI::Range(1, 1024));
}

io::Scene scene_of(const SceneOptions& options) {
    std::vector<std::string> overrides = options.overrides;
    if (!options.output.empty()) overrides.push_back("output.file=" + toml_text(options.output));
    if (options.threads > 0) overrides.push_back(text("run.threads={}", options.threads));
    return io::read_scene(options.scene, overrides);
}

void print_json(const nlohmann::json& value) {
    std::puts(value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

int print_outcome(const run::RunOutcome& outcome, bool json) {
    if (outcome.loop.signal != 0) {
        log_information("stopped by signal {} at step {} (t = {} s) after a checkpoint; to resume: drover restart {}",
                        outcome.loop.signal, outcome.loop.step, outcome.checkpoint_time, outcome.archive.string());
        return run::exit_stopped;
    }
    const run::Report& report = *outcome.report;
    if (json) {
        nlohmann::json result = run::report_json(report);
        result["archive"] = outcome.archive.string();
        result["steps"] = outcome.loop.step;
        result["wall_seconds"] = outcome.loop.wall_seconds;
        print_json(result);
        return run::exit_done;
    }
    std::fputs(printable(run::report_text(report)).c_str(), stdout);
    std::printf("\n%s: %s, %lld steps in %s\n", outcome.archive.c_str(),
                bytes_text(1e6 * outcome.archive_megabytes).c_str(), static_cast<long long>(outcome.loop.step),
                duration_text(outcome.loop.wall_seconds).c_str());
    return run::exit_done;
}

}  // namespace drover::app
