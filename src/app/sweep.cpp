// app/sweep.cpp: drover sweep SCENE.
#include "jobs/sweep.hpp"

#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "base/log.hpp"
#include "jobs/slurm_script.hpp"
#include "report/json.hpp"

namespace drover::app {

namespace {
struct SweepOptions : SceneOptions, ShareOptions {
    std::vector<std::string> vary, refine, want;
    std::string ramp, keep;
    int seeds = 0, max_seeds = 0, workers = 0, refine_levels = 0;
    bool json = false, quiet = false;
};

io::Scene scene_of(const SweepOptions& options, std::vector<std::string> overrides) {
    if (options.workers > 0) overrides.push_back(text("sweep.workers={}", options.workers));
    return io::read_scene(options.scene, overrides);
}

/// The settings that all shares have in common.
std::vector<std::string> settings_of(const SweepOptions& options) {
    std::vector<std::string> overrides = options.overrides;
    if (!options.vary.empty()) overrides.push_back("sweep.vary=" + toml_text(options.vary));
    if (!options.refine.empty()) overrides.push_back("sweep.refine=" + toml_text(options.refine));
    if (options.refine_levels > 0) overrides.push_back(text("sweep.refine_levels={}", options.refine_levels));
    if (!options.ramp.empty()) overrides.push_back("sweep.ramp=" + options.ramp);
    if (!options.keep.empty()) overrides.push_back("sweep.keep=" + options.keep);
    if (!options.want.empty()) overrides.push_back("sweep.want=" + toml_text(options.want));
    if (options.max_seeds > 0) overrides.push_back(text("sweep.max_seeds={}", options.max_seeds));
    if (options.seeds > 0) overrides.push_back(text("sweep.seeds={}", options.seeds));
    return overrides;
}

void print_table(const SweepOptions& options, const std::filesystem::path& folder, const jobs::SweepTable& table) {
    if (options.json) {
        print_json(report::table_json(table));
        for (const std::string& warning : table.warnings) log_warning("{}", warning);
        return;
    }
    print(jobs::table_text(table));
    print(text("\n{}: all single numbers; table.nc there: all observables over their axes\n",
               (folder / "table.csv").string()));
}

int print_outcome(const SweepOptions& options, const std::filesystem::path& folder, const jobs::SweepOutcome& outcome) {
    if (outcome.table && options.share.empty()) print_table(options, folder, *outcome.table);
    if (outcome.stopped) {
        log_information("stopped by {} after checkpoints; re-run the same command to resume",
                        run::stop_reason(run::stop_signal()));
        return run::exit_stopped;
    }
    const bool is_share = !options.share.empty();
    if (options.collect)
        for (const std::string& failure : outcome.failures) log_warning("{}", failure);
    if (outcome.failed > 0)
        log_warning("{} jobs failed, see above; re-run the same command{} to try them again", outcome.failed,
                    is_share          ? " without --share"
                    : options.collect ? " without --collect"
                                      : "");
    if (outcome.missing > 0 && !is_share)
        log_warning("{} of {} runs are missing; re-run the same command{} to run them", outcome.missing, outcome.runs,
                    options.collect ? " without --collect" : "");
    return outcome.failed + (is_share ? 0 : outcome.missing) > 0 ? run::exit_run_failed : run::exit_done;
}

int sweep_scene(const SweepOptions& options) {
    const std::vector<std::string> settings = settings_of(options);
    const io::Scene scene = scene_of(options, settings);
    const std::filesystem::path folder = jobs_output(options, ".sweep");
    require(!options.json || options.share.empty(), {},
            "--json with --share, which prints no table; give --json to "
            "--collect");
    if (options.status) {
        print(jobs::sweep_status(scene, folder) + "\n");
        return run::exit_done;
    }
    if (options.slurm > 0) {
        jobs::plan_sweep(scene);
        print(jobs::slurm_script({.command = "sweep",
                                  .scene = options.scene,
                                  .overrides = settings,
                                  .folder = folder,
                                  .shares = options.slurm}));
        return run::exit_done;
    }
    return print_outcome(options, folder,
                         jobs::run_sweep(scene, {.folder = folder,
                                                 .share = share_of(options),
                                                 .collect = options.collect,
                                                 .quiet = options.quiet}));
}
}  // namespace

void add_sweep(CLI::App& program, Action& action) {
    const auto options = std::make_shared<SweepOptions>();
    CLI::App* command =
        program.add_subcommand("sweep", "Run a scene over parameters, seeds or a ramp and tabulate; re-run to resume");
    add_scene_options(*command, *options);
    command->add_option("-o,--output", options->output,
                        "Folder of the sweep; default: the name of the scene with .sweep");
    command
        ->add_option(
            "--vary", options->vary,
            "Key and values, \"relaxation.rate = 0.5, 1, 2\" or \"relaxation.rate = 0.5:2:11\" (first:last:count); "
            "repeatable")
        ->type_name("KEY=VALUES");
    command
        ->add_option("--refine", options->refine,
                     "Observable and change, \"polar_order = 0.1\": add points between neighbours that differ by more; "
                     "repeatable")
        ->type_name("NAME=CHANGE");
    command->add_option("--refine-levels", options->refine_levels, "Times that their distance is halved at most")
        ->check(CLI::Range(1, 20));
    command->add_option("--seeds", options->seeds, "Number of runs at each point")->check(CLI::Range(1, 1000000));
    command
        ->add_option("--want", options->want,
                     "Observable and standard error, \"polar_order=2%\": add seeds at each point until its mean has "
                     "that error; repeatable")
        ->type_name("NAME=ERROR");
    command->add_option("--max-seeds", options->max_seeds, "With --want: the largest number of runs at a point")
        ->check(CLI::Range(2, 1000000));
    command->add_option(
        "--ramp", options->ramp,
        "Start each point from the final state of the one before: none, up or up-down; of several keys the "
        "last is ramped");
    command->add_option("--workers", options->workers, "Number of simultaneous runs")->check(CLI::Range(1, 1024));
    command->add_option("--keep", options->keep, "archives: an archive of each run; table: the results alone")
        ->type_name("WHAT");
    add_share_options(*command, *options,
                      {.work = "runs",
                       .collect = "Run nothing: make the table of the runs that have ended",
                       .status = "Print how far all processes have come: runs done, failed, running, their rate and "
                                 "the time left",
                       .slurm = "Print a script that runs N shares on Slurm and makes the table"});
    add_stop_options(*command);
    command->add_flag("--json", options->json, "Print the table as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log");
    command->callback([options, &action] { action = [options] { return sweep_scene(*options); }; });
}

}  // namespace drover::app
