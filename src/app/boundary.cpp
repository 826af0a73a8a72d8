// app/boundary.cpp: drover boundary SCENE, or drover boundary TABLE.
#include "jobs/boundary_shares.hpp"

#include <cstdlib>
#include <optional>

#include "analysis/onset.hpp"
#include "app/command.hpp"
#include "base/log.hpp"
#include "base/mapped.hpp"

namespace drover::app {

namespace {
struct BoundaryOptions : JobCommand {
    std::optional<double> varied, cell;
    std::optional<int> draws;
    std::vector<std::string> points;
    bool overwrite = false;
};

int print_scene_boundary(const BoundaryOptions& options) {
    for (const auto& [name, is_given] :
         {std::pair{"--varied", options.varied.has_value()}, std::pair{"--cell", options.cell.has_value()},
          std::pair{"--point", !options.points.empty()}})
        require(!is_given, {.file = options.scene},
                "{} applies to a table of coefficients, and this is a scene; omit it", name);
    std::vector<std::string> overrides = options.overrides;
    if (options.draws) overrides.push_back(text("boundary.draws={}", *options.draws));
    const io::Scene scene = io::read_scene(options.scene, overrides);
    io::require_grid(scene, "boundary");
    Threads threads(options.threads > 0 ? options.threads : scene.run.threads > 0 ? scene.run.threads : usable_cores());
    const ResultOutput output = output_of(options, "boundary", "all vertices, and the map of regimes");
    jobs::JobOptions job = job_of(options, ".boundary.h5");
    const std::filesystem::path archive = job.folder;  // jobs need one, and their folder is beside it
    job.folder += ".shares";
    if (answers(options, "boundary", archive,
                {.status = [&] { return jobs::boundary_status(scene, job.folder); },
                 .check =
                     [&] {
                         analysis::check_boundary(scene);
                         check_output(output, options.scene, scene);
                     },
                 .overrides = overrides,
                 .words = {"--overwrite"}}))  // the archive that the script has written, if it is run again
        return run::exit_done;
    if (job.share.is_plain()) check_output(output, options.scene, scene);
    if (!options.collect && options.share.empty() && options.workers == 0 && !jobs::has_shares(scene, job.folder))
        return print_result(analysis::make_boundary(scene, threads, {.quiet = options.quiet}), output, scene,
                            threads.count());
    const auto result = jobs::make_boundary_in_shares(scene, job, threads);
    if (result) return print_result(*result, output, scene, threads.count());
    if (run::stop_signal() == 0 && !job.share.is_plain()) return run::exit_done;
    log_information("{}; re-run the same command to resume",
                    run::stop_signal() == 0 ? std::string("points are missing, whose processes were stopped")
                                            : "stopped by " + run::stop_reason(run::stop_signal()));
    return run::exit_stopped;
}

constexpr int min_draws = 20;  ///< of a table: 16 % of them are three

/// "0.35,0.14" as area fractions of beads and rods.
analysis::AreaFractions point_of(const std::string& written) {
    double numbers[2] = {};
    char* end = nullptr;
    numbers[0] = std::strtod(written.c_str(), &end);
    const bool has_comma = *end == ',';
    if (has_comma) numbers[1] = std::strtod(end + 1, &end);
    require(has_comma && *end == '\0' && numbers[0] > 0.0 && numbers[1] > 0.0, {},
            "--point {}; expected area fractions of beads and rods, such as --point 0.35,0.14", written);
    return {numbers[0], numbers[1]};
}

int print_table_boundary(const BoundaryOptions& options) {
    const SourceLocation file{.file = options.scene};
    require(options.share.empty() && !options.collect && !options.status && options.slurm == 0 && options.workers == 0,
            file,
            "--share, --collect, --status, --workers and --slurm apply to scenes, and this is a table of coefficients, "
            "whose threshold takes seconds; expected none of them");
    require(options.overrides.empty(), file,
            "--set, --x, --y and --convention apply to scenes, and this is a table of coefficients, whose plane is "
            "that of its area fractions; expected none of them");
    require(!options.draws || *options.draws >= min_draws, {},
            "--draws {} for a table of coefficients; expected at least {}, from which its errors follow",
            *options.draws, min_draws);
    require(options.cell || options.points.empty(), {}, "--point applies to --cell; expected the side of a cell too");
    const std::vector<analysis::AreaFractions> points = mapped(options.points, point_of);
    analysis::TableOnset onset =
        analysis::make_onset(options.scene, options.varied, options.draws.value_or(calibrate::error_draws));
    const ResultOutput output = output_of(options, "onset", "curves and thresholds, with standard errors");
    check_output(output, options.scene, onset.scene);
    if (options.cell) analysis::add_cells(onset, *options.cell, points);
    return print_result(onset.result, output, onset.scene, 1);
}
}  // namespace

void add_boundary(CLI::App& program, Action& action) {
    const auto options = std::make_shared<BoundaryOptions>();
    CLI::App* command = program.add_subcommand(
        "boundary", "Phase boundaries in a plane of two parameters of a scene, or the flocking threshold of a table");
    command->add_option("scene", options->scene, "Scene (TOML input file), or table of coefficients (HDF5)")
        ->required();
    add_set_option(*command, *options);
    add_key<std::string>(*command, *options, "--x", "boundary.x",
                         "First axis, \"driving.strength = 0.5:2\"; overrides boundary.x")
        ->type_name("KEY=FROM:TO");
    add_key<std::string>(*command, *options, "--y", "boundary.y",
                         "Second axis, \"relaxation.rate = 0.1:1\"; overrides boundary.y")
        ->type_name("KEY=FROM:TO");
    add_key<std::vector<std::string>>(*command, *options, "--convention", "boundary.conventions",
                                      "Meaning of weathercock.strength: mean (lambda) or single-rod (lambda_s = 2 "
                                      "lambda); repeatable")
        ->type_name("NAME");
    command
        ->add_option("--draws", options->draws,
                     "Number of draws of all numbers with errors, for the error bands; overrides boundary.draws")
        ->type_name("N")
        ->check(CLI::Range(0, 10000));
    command
        ->add_option("--varied", options->varied, "For a table that varies a further key: the value of that key to use")
        ->type_name("VALUE");
    command
        ->add_option("--cell", options->cell,
                     "For a table: also the order of the rods in a square cell of this side [mm], with the effect of "
                     "their finite number")
        ->type_name("MM")
        ->check(CLI::PositiveNumber);
    command
        ->add_option("--point", options->points,
                     "For --cell: area fractions of beads and rods in place of those of the table; repeatable")
        ->type_name("BEADS,RODS");
    add_threads(*command, options->threads);
    command->add_flag("--overwrite", options->overwrite, "Replace an existing archive");
    add_job_options(*command, *options,
                    {.output = "Also write the result to this archive (HDF5)",
                     .work = "points of the lines",
                     .workers = "Number of processes that compute the points of a share, or those left by the shares",
                     .collect = "Compute no lines: take those that all processes have computed",
                     .status = "Print how far all processes have come",
                     .slurm = "Print a script that runs N shares on Slurm and writes the archive",
                     .json = "Print the result as JSON, with all vertices",
                     .quiet = "Print no progress"});
    command->get_option("--overwrite")->needs(command->get_option("--output"));
    when_chosen(*command, action, options, [](const BoundaryOptions& given) {
        return files::is_hdf5(given.scene) ? print_table_boundary(given) : print_scene_boundary(given);
    });
}

}  // namespace drover::app
