// app/sweep.cpp: drover sweep SCENE.
#include "jobs/sweep/sweep.hpp"

#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "base/log.hpp"
#include "report/shown.hpp"

namespace drover::app {

namespace {
void print_table(const JobCommand& options, const std::filesystem::path& folder, const jobs::SweepTable& table) {
    if (options.json) {
        print_json(report::json_of(table));
        for (const std::string& warning : table.warnings) log_warning("{}", warning);
        return;
    }
    print(report::text_of(table));
    print(text("\n{}: all single numbers; table.nc there: all observables over their axes\n",
               (folder / "table.csv").string()));
}

int print_outcome(const JobCommand& options, const std::filesystem::path& folder, const jobs::SweepOutcome& outcome) {
    if (outcome.table && options.share.empty()) print_table(options, folder, *outcome.table);
    if (outcome.stopped) return print_stopped(" after checkpoints;");
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

int sweep_scene(const JobCommand& options) {
    const io::Scene scene = io::read_scene(options.scene, options.overrides);
    const jobs::JobOptions job = job_of(options, ".sweep");
    if (answers(options, "sweep", job.folder,
                {.status = [&] { return jobs::sweep_status(scene, job.folder); },
                 .check = [&] { jobs::plan_sweep(scene); },
                 .overrides = options.overrides}))
        return run::exit_done;
    return print_outcome(options, job.folder, jobs::run_sweep(scene, job));
}
}  // namespace

void add_sweep(CLI::App& program, Action& action) {
    const auto options = std::make_shared<JobCommand>();
    CLI::App* command =
        program.add_subcommand("sweep", "Run a scene over parameters, seeds or a ramp and tabulate; re-run to resume");
    add_scene_options(*command, *options);
    using Texts = std::vector<std::string>;
    add_key<Texts>(*command, *options, "--vary", "sweep.vary",
                   "Key and values, \"relaxation.rate = 0.5, 1, 2\" or \"relaxation.rate = 0.5:2:11\" "
                   "(first:last:count); repeatable")
        ->type_name("KEY=VALUES");
    add_key<Texts>(*command, *options, "--refine", "sweep.refine",
                   "Observable and change, \"polar_order = 0.1\": add points between neighbours that differ by more; "
                   "repeatable")
        ->type_name("NAME=CHANGE");
    add_key<int>(*command, *options, "--refine-levels", "sweep.refine_levels",
                 "Maximum number of times that --refine halves the distance of points")
        ->check(CLI::Range(1, 20));
    add_key<int>(*command, *options, "--seeds", "sweep.seeds", "Number of runs at each point")
        ->check(CLI::Range(1, 1000000));
    add_key<Texts>(*command, *options, "--want", "sweep.want",
                   "Observable and standard error, \"polar_order=2%\": add seeds at each point until its mean has that "
                   "error; repeatable")
        ->type_name("NAME=ERROR");
    add_key<int>(*command, *options, "--max-seeds", "sweep.max_seeds",
                 "With --want: the largest number of runs at a point")
        ->check(CLI::Range(2, 1000000));
    add_key<std::string>(*command, *options, "--ramp", "sweep.ramp",
                         "Start each point from the final state of the one before: none, up or up-down; of several "
                         "keys the last is ramped");
    add_key<std::string>(*command, *options, "--keep", "sweep.keep",
                         "archives: an archive of each run; table: the results alone")
        ->type_name("WHAT");
    add_job_options(*command, *options,
                    {.output = "Folder of the sweep; default: the name of the scene with .sweep",
                     .work = "runs",
                     .workers = "Number of simultaneous runs",
                     .collect = "Run nothing: make the table of the runs that have ended",
                     .status = "Print how far all processes have come: runs done, failed, running, their rate and the "
                               "time left",
                     .slurm = "Print a script that runs N shares on Slurm and makes the table"});
    add_stop_options(*command);
    when_chosen(*command, action, options, sweep_scene);
}

}  // namespace drover::app
