// app/stability.cpp: drover stability SCENE.
#include "drover/run/stability.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "command.hpp"
#include "drover/run/field_simulation.hpp"

namespace drover::app {

namespace {
constexpr double degree = std::numbers::pi / 180.0;

nlohmann::json coefficients_json(const physics::EffectiveCoefficients& c) {
    return {{"inertia", number_json(c.inertia)},
            {"relaxation", number_json(c.relaxation)},
            {"relaxation_by_beads", number_json(c.relaxation_by_beads)},
            {"relaxation_by_rods", number_json(c.relaxation_by_rods)},
            {"pressure_beads", number_json(c.pressure_beads)},
            {"pressure_rods", number_json(c.pressure_rods)},
            {"stiffness_across", number_json(c.stiffness_across)},
            {"stiffness_along", number_json(c.stiffness_along)},
            {"sound_stiffness", number_json(c.sound_stiffness)},
            {"correlation_length", number_json(c.correlation_length)},
            {"neutral_wavenumber", number_json(c.neutral_wavenumber)}};
}

nlohmann::json state_json(const run::StateStability& one) {
    nlohmann::json instabilities = nlohmann::json::array(), slow = nlohmann::json::array();
    for (const physics::Instability& found : one.instabilities)
        instabilities.push_back({{"name", found.name},
                                 {"rate", found.rate},
                                 {"frequency", found.frequency},
                                 {"wavenumber", found.q},
                                 {"angle", found.angle / degree},
                                 {"grows_from", found.min},
                                 {"grows_to", number_json(found.max)},
                                 {"at_longest", found.at_longest},
                                 {"at_shortest", found.at_shortest}});
    for (const run::SlowAngle& at : one.slow)
        for (const physics::SlowMode& mode : at.modes)
            slow.push_back({{"angle", at.angle / degree},
                            {"speed", mode.speed.real()},
                            {"growth", mode.speed.imag()},
                            {"damping", number_json(mode.damping.real())}});
    const physics::UniformPoint& point = one.state.point;
    return {{"name", one.state.name},
            {"order", {point.order.x(), point.order.y()}},
            {"velocity", {point.velocity.x(), point.velocity.y()}},
            {"stable", one.instabilities.empty()},
            {"instabilities", instabilities},
            {"slow_modes", slow},
            {"slow_modes_undefined", one.waves.undefined},
            {"direction_diffusion_times_area", number_json(one.direction_diffusion)}};
}
}  // namespace

void add_stability(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        bool json = false, overwrite = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand(
        "stability",
        "uniform states of a scene: what grows on them, sound and damping by angle, structure factors; runs nothing");
    add_scene_options(*command, *options);
    command->add_option("-o,--output", options->output,
                        "also write the maps over wavenumber and angle to this archive (HDF5)");
    command->add_option("--threads", options->threads, "threads, in place of run.threads")->check(CLI::Range(1, 1024));
    command->add_flag("--overwrite", options->overwrite, "replace an archive that exists");
    command->add_flag("--json", options->json, "as JSON");
    command->callback([options, &action] {
        action = [options] {
            const io::Scene scene = io::read_scene(options->scene, options->overrides);
            io::require_kind(scene, io::SceneKind::fields, "stability");
            Threads threads(options->threads > 0 ? options->threads : run::choose_threads(scene));
            const run::StabilityReport report = run::make_stability(scene);
            if (!options->output.empty())
                write_results(options->output, "stability", scene, threads.count(),
                              run::stability_tables(report, threads), {}, options->overwrite);
            if (!options->json) {
                std::fputs(run::stability_text(report).c_str(), stdout);
                if (!options->output.empty())
                    std::printf("\n%s: maps over wavenumber and angle\n", options->output.c_str());
                return run::exit_done;
            }
            nlohmann::json states = nlohmann::json::array();
            for (const run::StateStability& one : report.states) states.push_back(state_json(one));
            const nlohmann::json result{{"form", report.form},
                                        {"coefficients", coefficients_json(report.coefficients)},
                                        {"states", states},
                                        {"no_order", report.no_order},
                                        {"searched_from", report.search.min},
                                        {"searched_to", report.search.max},
                                        {"notes", report.notes}};
            std::puts(result.dump(2).c_str());
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
