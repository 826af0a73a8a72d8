// app/boundary.cpp: drover boundary SCENE.
#include "drover/run/boundary.hpp"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "boundary_table.hpp"
#include "drover/run/field_simulation.hpp"

namespace drover::app {

namespace {
nlohmann::json line_json(const physics::BoundaryLine& line) {
    nlohmann::json points = nlohmann::json::array();
    for (const physics::BoundaryPoint& point : line.points)
        points.push_back({{"x", point.x},
                          {"y", point.y},
                          {"error_x", number_json(point.error_x)},
                          {"error_y", number_json(point.error_y)},
                          {"angle", point.angle * 180.0 / std::numbers::pi}});
    return {{"closed", line.closed}, {"points", points}};
}

nlohmann::json report_json(const run::BoundaryReport& report) {
    nlohmann::json traced = nlohmann::json::array();
    for (const run::TracedLines& one : report.traced) {
        nlohmann::json lines = nlohmann::json::array(), sharp = nlohmann::json::array();
        for (const physics::BoundaryLine& line : one.boundary.lines) lines.push_back(line_json(line));
        for (const numerics::PlanePoint& point : one.boundary.sharp) sharp.push_back({point.x, point.y});
        traced.push_back({{"limit", physics::limit_name(one.limit)},
                          {"convention", one.convention},
                          {"lines", lines},
                          {"sharp", sharp},
                          {"complete", one.boundary.complete},
                          {"evaluations", one.boundary.evaluations}});
    }
    const auto axis = [](const physics::PlaneAxis& a) {
        return nlohmann::json{{"name", a.name}, {"unit", a.unit}, {"from", a.from}, {"to", a.to}};
    };
    return {{"x", axis(report.x)}, {"y", axis(report.y)}, {"uncertain_numbers", report.uncertain}, {"traced", traced}};
}
}  // namespace

namespace {
struct Options : SceneOptions {
    std::string x, y;
    std::vector<std::string> conventions;
    std::optional<double> varied;
    bool json = false, overwrite = false;
};

int print_scene_boundary(const Options& options) {
    require(!options.varied, {.file = options.scene},
            "--varied is for a table of coefficients, and this is a scene; expected the command without it");
    std::vector<std::string> overrides = options.overrides;
    if (!options.x.empty()) overrides.push_back("boundary.x=" + toml_text(options.x));
    if (!options.y.empty()) overrides.push_back("boundary.y=" + toml_text(options.y));
    if (!options.conventions.empty()) overrides.push_back("boundary.conventions=" + toml_text(options.conventions));
    const io::Scene scene = io::read_scene(options.scene, overrides);
    io::require_kind(scene, io::SceneKind::fields, "boundary");
    Threads threads(options.threads > 0 ? options.threads : scene.run.threads > 0 ? scene.run.threads : usable_cores());
    const run::BoundaryReport report = run::make_boundary(scene, threads);
    if (!options.output.empty())
        write_results(options.output, "boundary", scene, threads.count(), run::boundary_tables(report),
                      {{"boundary_x", report.x.name}, {"boundary_y", report.y.name}}, options.overwrite);
    if (options.json) std::puts(report_json(report).dump(2).c_str());
    else std::fputs(run::boundary_text(report).c_str(), stdout);
    if (!options.json && !options.output.empty())
        std::printf("\n%s: all vertices, and the map of states\n", options.output.c_str());
    return run::exit_done;
}

int print_boundary(const Options& options) {
    if (!files::is_hdf5(options.scene)) return print_scene_boundary(options);
    require(options.overrides.empty() && options.x.empty() && options.y.empty() && options.conventions.empty(),
            {.file = options.scene},
            "--set, --x, --y and --convention are for scenes, and this is a table of coefficients, whose plane is "
            "that of its area fractions; expected the command without them");
    return print_table_boundary({.file = options.scene,
                                 .output = options.output,
                                 .varied = options.varied,
                                 .json = options.json,
                                 .overwrite = options.overwrite});
}
}  // namespace

void add_boundary(CLI::App& program, Action& action) {
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand("boundary",
                                               "phase boundaries in a plane of two numbers of a scene: onset of a "
                                               "flock, banding, oblique waves; or where a table of coefficients says "
                                               "that flocks begin; runs nothing");
    add_scene_options(*command, *options);
    command->add_option("--x", options->x, "\"driving.strength = 0.5:2\", in place of boundary.x")
        ->type_name("KEY=FROM:TO");
    command->add_option("--y", options->y, "\"relaxation.rate = 0.1:1\", in place of boundary.y")
        ->type_name("KEY=FROM:TO");
    command
        ->add_option(
            "--convention", options->conventions,
            "what weathercock.strength is: mean (lambda) or single-rod (lambda_s = 2 lambda); both may be given")
        ->type_name("NAME");
    command->add_option("--varied", options->varied, "of a table: which value of the key that it varies")
        ->type_name("VALUE");
    command->add_option("-o,--output", options->output, "also write lines and map to this archive (HDF5)");
    command->add_option("--threads", options->threads, "threads, in place of run.threads")->check(CLI::Range(1, 1024));
    command->add_flag("--overwrite", options->overwrite, "replace an archive that exists");
    command->add_flag("--json", options->json, "as JSON, every vertex");
    command->callback([options, &action] { action = [options] { return print_boundary(*options); }; });
}

}  // namespace drover::app
