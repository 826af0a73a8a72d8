// app/calibrate.cpp: drover calibrate SCENE.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/base/log.hpp"
#include "drover/run/calibration.hpp"

namespace drover::app {

namespace {
struct Options : SceneOptions {
    std::string share;
    int workers = 0, slurm = 0;
    bool collect = false, json = false, quiet = false;
};

/// "2/8": the second of eight shares.
void read_share(const std::string& written, run::CalibrationOptions& to) {
    int used = 0;
    const bool whole = std::sscanf(written.c_str(), "%d/%d%n", &to.share, &to.shares, &used) == 2 &&
                       used == static_cast<int>(written.size());
    require(whole && to.share >= 1 && to.share <= to.shares, {},
            "--share {}; expected I/N with I from 1 to N, such as 2/8", written);
}

/// Quoted for the shell.
std::string shell_word(const std::string& word) {
    std::string quoted = "'";
    for (const char letter : word) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
    return quoted + "'";
}

/// Submits the shares as an array, and a job that makes the table after them.
std::string slurm_script(const Options& options, const std::filesystem::path& folder) {
    std::string command =
        text("drover calibrate {} --output {} --quiet", shell_word(std::filesystem::absolute(options.scene).string()),
             shell_word(std::filesystem::absolute(folder).string()));
    for (const std::string& setting : options.overrides) command += " --set " + shell_word(setting);
    return text(R"(#!/bin/sh
# Measures the coefficients of {0} as {1} array tasks of Slurm and makes their table.
# Run it with sh; options are passed to sbatch, as in
#     sh calibrate.sh --partition=short --time=12:00:00 --cpus-per-task=8
# Re-run it to resume after a time limit or a failure: no trial that has ended is run again.
# All tasks need access to the same folder.
set -eu
calibrate={2}
array=$(sbatch --parsable --job-name=drover --array=1-{1} "$@" \
    --wrap "exec $calibrate --share \$SLURM_ARRAY_TASK_ID/{1} --workers \${{SLURM_CPUS_PER_TASK:-1}}")
sbatch --parsable --job-name=drover-table --dependency="afterany:${{array%%;*}}" "$@" --wrap "exec $calibrate --collect"
)",
                options.scene, options.slurm, shell_word(command));
}

int print_outcome(const Options& options, const run::CalibrationOutcome& outcome) {
    if (outcome.table && options.json) {
        const nlohmann::json result{{"table", outcome.file.string()},
                                    {"trials_run", outcome.trials},
                                    {"trials_found", outcome.already},
                                    {"coefficients", table_json(*outcome.table)}};
        print_json(result);
    } else if (outcome.table) {
        std::fputs(run::calibration_text(*outcome.table).c_str(), stdout);
        std::printf("\n%s: all coefficients, with errors, trials and origins; as text: table.toml\n",
                    outcome.file.c_str());
    }
    if (outcome.unmet_targets > 0)
        log_warning("{} of {} measurements have a larger error than requested; they are kept and marked",
                    outcome.unmet_targets, outcome.units);
    if (outcome.stopped) {
        log_information("stopped by a signal; re-run the same command to resume");
        return run::exit_stopped;
    }
    if (outcome.failed > 0) log_warning("{} of {} measurements failed, see above", outcome.failed, outcome.units);
    if (outcome.unfinished > 0)
        log_warning("{} of {} measurements are not finished; re-run the same command without --collect to resume",
                    outcome.unfinished, outcome.units);
    return outcome.failed + outcome.unfinished > 0 ? run::exit_run_failed : run::exit_done;
}

int calibrate_scene(const Options& options) {
    std::vector<std::string> overrides = options.overrides;
    if (options.workers > 0) overrides.push_back(text("calibrate.workers={}", options.workers));
    const io::Scene scene = io::read_scene(options.scene, overrides);
    run::CalibrationOptions how{.folder = options.output.empty()
                                              ? std::filesystem::path(options.scene).stem().concat(".calibration")
                                              : std::filesystem::path(options.output),
                                .collect = options.collect,
                                .quiet = options.quiet};
    if (!options.share.empty()) read_share(options.share, how);
    require(!options.json || options.share.empty(), {},
            "--json with --share, which makes no table; give --json to --collect");
    if (options.slurm > 0) {
        run::plan_calibration(scene);
        std::fputs(slurm_script(options, how.folder).c_str(), stdout);
        return run::exit_done;
    }
    return print_outcome(options, run::run_calibration(scene, how));
}
}  // namespace

nlohmann::json table_json(const calibrate::Table& table) {
    nlohmann::json coefficients = nlohmann::json::object();
    for (const calibrate::TableRow& row : table.rows) {
        nlohmann::json points = nlohmann::json::array();
        const std::size_t rods = row.by_rods ? table.rod_fractions.size() : 1, beads = table.bead_fractions.size();
        for (std::size_t place = 0; place < row.entries.size(); ++place) {
            const calibrate::TableEntry& known = row.entries[place];
            nlohmann::json point{{"bead_area_fraction", table.bead_fractions[place / rods % beads]},
                                 {"value", number_json(known.value)},
                                 {"error", number_json(known.error)},
                                 {"trials", known.trials},
                                 {"origin", calibrate::origin_name(known.origin)},
                                 {"remark", known.remark}};
            if (row.by_rods) point["rod_area_fraction"] = table.rod_fractions[place % rods];
            if (!table.varied_key.empty()) point[table.varied_key] = table.varied[place / rods / beads];
            points.push_back(std::move(point));
        }
        coefficients[row.name] = {{"unit", row.unit}, {"formula", row.formula}, {"points", std::move(points)}};
    }
    return coefficients;
}

void add_calibrate(CLI::App& program, Action& action) {
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("calibrate",
                               "Measure the coefficients in particle simulations over area fractions and "
                               "tabulate; re-run to resume");
    add_scene_options(*command, *options);
    command->add_option("-o,--output", options->output,
                        "Folder of the trials and the table; default: the name of the scene with .calibration");
    command->add_option("--workers", options->workers, "Number of simultaneous trials")->check(CLI::Range(1, 1024));
    CLI::Option* share =
        command
            ->add_option("--share", options->share, "Run only the I-th of N shares in a common folder; writes no table")
            ->type_name("I/N");
    CLI::Option* collect =
        command->add_flag("--collect", options->collect, "Run no trials: make the table from those that have ended")
            ->excludes(share);
    command
        ->add_option("--slurm", options->slurm, "Print a script that runs N shares on Slurm and then makes the table")
        ->type_name("N")
        ->check(CLI::Range(1, 100000))
        ->excludes(share)
        ->excludes(collect);
    command->add_flag("--json", options->json, "Print the table as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log");
    command->callback([options, &action] { action = [options] { return calibrate_scene(*options); }; });
}

}  // namespace drover::app
