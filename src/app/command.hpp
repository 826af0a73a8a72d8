// app/command.hpp: what the commands share: each adds itself to the command line and says what it does.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"
#include "drover/files/archive.hpp"
#include "drover/io/scene_text.hpp"
#include "drover/run/exit_status.hpp"
#include "drover/run/report.hpp"
#include "drover/run/run_scene.hpp"

namespace drover::app {

/// What the command line asked for; returns the exit status.
using Action = std::function<int()>;

void add_run(CLI::App& program, Action& action);
void add_restart(CLI::App& program, Action& action);
void add_sweep(CLI::App& program, Action& action);
void add_check(CLI::App& program, Action& action);
void add_explain(CLI::App& program, Action& action);
void add_calibrate(CLI::App& program, Action& action);
void add_stability(CLI::App& program, Action& action);
void add_boundary(CLI::App& program, Action& action);
void add_info(CLI::App& program, Action& action);
void add_export(CLI::App& program, Action& action);
void add_schema(CLI::App& program, Action& action);

/// Options that several commands have.
struct SceneOptions {
    std::string scene;
    std::vector<std::string> overrides;
    std::string output;
    int threads = 0;
};
/// The positional SCENE and --set.
void add_scene_options(CLI::App& command, SceneOptions& options);
/// --output and --threads, as the overrides that they are.
void add_output_options(CLI::App& command, SceneOptions& options);
/// The scene with all its overrides.
io::Scene scene_of(const SceneOptions& options);

/// drover explain of a scene of particles.
void explain_particles(const io::Scene& scene, bool json);

/// A number, or null when it is not finite.
nlohmann::json number_json(double value);

/// Writes groups of results, with where they came from, as an archive of their own.  Throws as files::Archive::create.
void write_results(const std::string& file, const std::string& what, const io::Scene& scene, int threads,
                   const std::vector<files::ResultTable>& tables, const std::vector<files::Attribute>& more,
                   bool overwrite);

/// The results, for programs; numbers that are not finite become null.
nlohmann::json report_json(const run::Report& report);
/// The provenance of an archive.
nlohmann::json attributes_json(const files::ArchiveReader& archive);

/// Coefficients by name, each with its points.
nlohmann::json table_json(const calibrate::Table& table);

/// Prints how a run ended and what came out; returns its exit status.
int print_outcome(const run::RunOutcome& outcome, bool json);

}  // namespace drover::app
