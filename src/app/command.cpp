// app/command.cpp: options and results that several commands share.
#include "command.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "drover/base/log.hpp"
#include "drover/run/kind.hpp"

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

nlohmann::json number_json(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

void print_json(const nlohmann::json& value) {
    std::puts(value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

namespace {

nlohmann::json estimate_json(const measure::Estimate& estimate) {
    nlohmann::json result{{"mean", number_json(estimate.mean)},
                          {"error", estimate.error ? number_json(*estimate.error) : nlohmann::json(nullptr)},
                          {"autocorrelation_time", number_json(estimate.autocorrelation_time)},
                          {"warm_up", number_json(estimate.warm_up)},
                          {"samples", estimate.samples}};
    if (!estimate.refusal.empty()) result["refusal"] = estimate.refusal;
    return result;
}
}  // namespace

nlohmann::json report_json(const run::Report& report) {
    nlohmann::json rows = nlohmann::json::object();
    for (const measure::SummaryRow& row : report.summary.rows) {
        nlohmann::json entry{{"unit", row.unit}, {"formula", row.formula}};
        if (row.axes.empty()) {
            entry.update(estimate_json(row.estimates.front()));
        } else {
            for (const measure::Estimate& estimate : row.estimates) entry["values"].push_back(estimate_json(estimate));
        }
        if (const run::Prediction* prediction = run::find_prediction(report, row.name))
            for (const double value : prediction->values) entry["linear"].push_back(number_json(value));
        rows[row.name] = std::move(entry);
    }
    return {{"time", report.time},
            {"samples", report.summary.samples},
            {"warm_up_samples", report.summary.warm_up},
            {"note", report.summary.note},
            {"warnings", report.warnings},
            {"no_prediction", report.no_prediction},
            {"linear_about", report.about},
            {"results", std::move(rows)}};
}

nlohmann::json attributes_json(const files::ArchiveReader& archive) {
    nlohmann::json result = nlohmann::json::object();
    for (const auto& [name, value] : archive.attributes())
        std::visit([&](const auto& held) { result[name] = held; }, value);
    return result;
}

int print_outcome(const run::RunOutcome& outcome, bool json) {
    if (outcome.loop.signal != 0) {
        log_information("stopped by signal {} at step {} (t = {} s) after a checkpoint; to resume: drover restart {}",
                        outcome.loop.signal, outcome.loop.step, outcome.checkpoint_time, outcome.archive.string());
        return run::exit_stopped;
    }
    const run::Report report = run::make_report(files::ArchiveReader(outcome.archive));
    if (json) {
        nlohmann::json result = report_json(report);
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
