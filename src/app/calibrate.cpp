// app/calibrate.cpp: drover calibrate SCENE.
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "base/duration.hpp"
#include "base/log.hpp"
#include "jobs/calibration/calibration.hpp"
#include "report/shown.hpp"

namespace drover::app {

namespace {
struct CalibrateOptions : JobCommand {
    std::string budget;
    std::vector<std::string> targets;
};

int print_outcome(const CalibrateOptions& options, const jobs::CalibrationOutcome& outcome) {
    const bool is_share = !options.share.empty();
    if (outcome.table && options.json) {
        nlohmann::json result{{"table", outcome.file.string()},
                              {"trials_run", outcome.trials},
                              {"trials_found", outcome.already},
                              {"coefficients", report::json_of(*outcome.table)}};
        if (outcome.want) result["want"] = run::result_json(*outcome.want);
        print_json(result);
    } else if (outcome.table && !is_share) {
        print(report::text_of(*outcome.table));
        if (outcome.want) print("\n" + run::result_text(*outcome.want));
        print(text("\n{}: all coefficients, with errors, trials and origins; as text: table.toml\n",
                   outcome.file.string()));
    }
    if (outcome.unmet_targets > 0)
        log_warning("{} of {} measurements have a larger error than requested; they are kept and marked",
                    outcome.unmet_targets, outcome.units);
    if (outcome.stopped) return print_stopped(";");
    if (outcome.failed > 0) log_warning("{} of {} measurements failed, see above", outcome.failed, outcome.units);
    if (outcome.unfinished > 0 && !is_share)
        log_warning("{} of {} measurements are not finished; re-run the same command{} to resume", outcome.unfinished,
                    outcome.units, options.collect ? " without --collect" : "");
    if (outcome.unmet_wants > 0 && !is_share)
        log_warning("{} wanted numbers did not reach their errors; the reasons are listed with them",
                    outcome.unmet_wants);
    const std::size_t open = is_share ? outcome.crashed : outcome.unfinished + outcome.unmet_wants;
    return outcome.failed + open > 0 ? run::exit_run_failed : run::exit_done;
}

int calibrate_scene(const CalibrateOptions& options) {
    const io::Scene scene = io::read_scene(options.scene, options.overrides);
    const double budget = options.budget.empty() ? INFINITY : seconds_of(options.budget, "--budget");
    const jobs::TargetOptions how = jobs::target_options(job_of(options, ".calibration"), options.targets, budget);
    std::vector<std::string> words;
    for (const std::string& target : options.targets) words.insert(words.end(), {"--want", target});
    if (!options.budget.empty()) words.insert(words.end(), {"--budget", options.budget});
    if (answers(options, "calibrate", how.folder,
                {.status = [&] { return jobs::calibration_status(scene, how); },
                 .check = [&] { jobs::needed_assays(jobs::plan_calibration(scene), how.targets); },
                 .overrides = options.overrides,
                 .words = words}))
        return run::exit_done;
    return print_outcome(options, jobs::run_calibration(scene, how));
}
}  // namespace

void add_calibrate(CLI::App& program, Action& action) {
    const auto options = std::make_shared<CalibrateOptions>();
    CLI::App* command =
        program.add_subcommand("calibrate",
                               "Measure the coefficients in particle simulations over area fractions and "
                               "tabulate; re-run to resume");
    add_scene_options(*command, *options);
    CLI::Option* want =
        command
            ->add_option("--want", options->targets,
                         "A number and its standard error: onset=5%, \"onset(Phi_r<0.06)=0.02\", "
                         "\"alignment(0.35<Phi_b<0.45)=10%\"; trials are spread so that it is reached at the least "
                         "cost, and calibrate.relative_error and round have no effect; repeatable")
            ->type_name("NUMBER=ERROR");
    command->add_option("--budget", options->budget, "Core time of all trials for --want: 90s, 20min, 2h")
        ->type_name("TIME")
        ->needs(want);
    add_job_options(*command, *options,
                    {.output = "Folder of the trials and the table; default: the name of the scene with .calibration",
                     .work = "trials",
                     .workers = "Number of simultaneous trials",
                     .collect = "Run no trials: make the table from those that have ended",
                     .status = "Print how far all processes have come: measurements and trials done, trials failed and "
                               "running, their rate and the time left",
                     .slurm = "Print a script that runs N shares on Slurm and makes the table"});
    add_stop_options(*command);
    when_chosen(*command, action, options, calibrate_scene);
}

}  // namespace drover::app
