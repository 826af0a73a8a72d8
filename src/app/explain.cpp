// app/explain.cpp: drover explain SCENE.
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/run_scene.hpp"

namespace drover::app {

namespace {
struct Explanation {
    std::vector<physics::Component> fields;
    std::vector<physics::ActiveTerm> terms;
    physics::FastestGrowth growth;
    double fastest_rate = 0.0;  ///< |s|max [1/s]
    std::int64_t steps = 0;
    int threads = 1;
    int transforms = 0;  ///< per right-hand side
    run::Needs needs;
};

Explanation explain(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    const numerics::System system = physics::linear_system(scene.model, scene.grid, scene.dealiasing);
    return {.fields = physics::component_names(physics::form(scene.model)),
            .terms = physics::active_terms(equations),
            .growth = physics::fastest_growth(system),
            .fastest_rate = physics::fastest_rate(system),
            .steps = io::whole_steps(scene, "time.end", scene.time.end),
            .threads = run::choose_threads(scene),
            .transforms = 0,  // every term is linear: it acts on the Fourier coefficients alone
            .needs = run::needs_of(scene)};
}

nlohmann::json explanation_json(const io::Scene& scene, const Explanation& e) {
    nlohmann::json fields = nlohmann::json::array(), terms = nlohmann::json::array();
    for (const physics::Component& field : e.fields) fields.push_back({{"name", field.name}, {"unit", field.unit}});
    for (const physics::ActiveTerm& term : e.terms) terms.push_back({{"name", term.name}, {"equation", term.equation}});
    return {{"fields", fields},
            {"terms", terms},
            {"transforms_per_right_hand_side", e.transforms},
            {"steps", e.steps},
            {"threads", e.threads},
            {"fastest_rate", e.fastest_rate},
            {"dt_times_fastest_rate", scene.time.dt * e.fastest_rate},
            {"growth_rate", e.growth.rate},
            {"growth_wavenumber", e.growth.q},
            {"memory_bytes", e.needs.memory_bytes},
            {"disk_bytes", e.needs.disk_bytes},
            {"archive", run::archive_path(scene).string()}};
}

void print(const io::Scene& scene, const Explanation& e) {
    const numerics::StepperTable& stepper = numerics::stepper_table(scene.time.stepper);
    std::printf("fields on %d by %d points, %g by %g mm\n", scene.grid.nx, scene.grid.ny, scene.grid.lx, scene.grid.ly);
    for (const physics::Component& field : e.fields)
        std::printf("  %-16s [%s]  %s\n", field.name.c_str(), field.unit.c_str(), field.meaning.c_str());
    std::printf("terms\n");
    for (const physics::ActiveTerm& term : e.terms)
        std::printf("  %-16s %s\n", term.name.c_str(), term.equation.c_str());
    std::printf("stepper %s, order %d: %s\n", stepper.name.c_str(), stepper.order, stepper.citation.c_str());
    std::printf("  %d transforms per right-hand side%s; 3 per frame and per sample\n", e.transforms,
                e.transforms == 0 ? ": every term is linear and acts exactly on the Fourier coefficients" : "");
    std::printf("  %lld steps of dt = %g s; dt |s|max = %.3g (exact at any)\n", static_cast<long long>(e.steps),
                scene.time.dt, scene.time.dt * e.fastest_rate);
    if (e.growth.rate > 0.0)
        std::printf(
            "  unstable: a mode grows at %.4g /s at |q| = %.3g /mm, by e^%.3g in this run, and no term stops it\n",
            e.growth.rate, e.growth.q, e.growth.rate * scene.time.end);
    else if (e.growth.rate == 0.0)
        std::printf("  neutral: a mode neither grows nor decays at |q| = %.3g /mm\n", e.growth.q);
    else std::printf("  stable: the slowest mode decays at %.4g /s at |q| = %.3g /mm\n", -e.growth.rate, e.growth.q);
    std::printf("memory %s (%s free), disk at most %s (%s free), %d thread%s\n",
                bytes_text(e.needs.memory_bytes).c_str(), bytes_text(e.needs.memory_free).c_str(),
                bytes_text(e.needs.disk_bytes).c_str(), bytes_text(e.needs.disk_free).c_str(), e.threads,
                e.threads == 1 ? "" : "s");
    std::printf("archive %s\n", run::archive_path(scene).c_str());
}
}  // namespace

void add_explain(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("explain",
                               "what a scene computes and what it costs: fields, terms, transforms, memory, disk");
    add_scene_options(*command, *options);
    add_output_options(*command, *options);
    command->add_flag("--json", options->json, "as JSON");
    command->callback([options, &action] {
        action = [options] {
            const io::Scene scene = scene_of(*options);
            const Explanation explanation = explain(scene);
            if (options->json) std::puts(explanation_json(scene, explanation).dump(2).c_str());
            else print(scene, explanation);
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
