// app/explain.cpp: drover explain SCENE.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/numerics/time_method.hpp"
#include "drover/run/model_explain.hpp"
#include "drover/run/step_choice.hpp"
#include "explain_cost.hpp"
#include "run/json.hpp"

namespace drover::app {

namespace {
void print_transforms(const run::FieldExplanation& e) {
    if (!e.is_nonlinear) {
        std::printf("  no transforms: every term is linear and acts exactly on the Fourier modes\n");
    } else {
        const int each = e.transforms.inverse + e.transforms.forward;
        std::printf("  %d real transforms per right-hand side (%d inverse, %d forward)%s\n", each, e.transforms.inverse,
                    e.transforms.forward,
                    e.stages > 0 ? text(", {} per step", each * e.stages).c_str()
                                 : "; right-hand sides per step as time.tolerance requires");
    }
    if (!e.without_degree.empty())
        std::printf("  no finite degree: %s; aliases are not removed exactly, see spectral_tail in the output\n",
                    joined(e.without_degree).c_str());
    std::printf("  products of degree %d: modes up to %d along x and %d along y are kept (dealiasing)\n", e.degree,
                e.kept_x, e.kept_y);
}

void print_explanation(const io::Scene& scene, const run::FieldExplanation& e) {
    const numerics::TimeMethod& stepper = numerics::time_method(scene.time.stepper);
    std::printf("form: %s\n", e.form.c_str());
    std::printf("fields on %d by %d points, %g by %g mm\n", scene.grid.nx, scene.grid.ny, scene.grid.lx, scene.grid.ly);
    for (const physics::Component& field : e.fields)
        std::printf("  %-16s %-9s %s\n", field.name.c_str(), ("[" + field.unit + "]").c_str(), field.meaning.c_str());
    std::printf("terms\n");
    for (const physics::ActiveTerm& term : e.terms)
        std::printf("  %-21s %s\n", term.name.c_str(), term.equation.c_str());
    if (scene.model.approximation.quasi_linear)
        std::printf("quasi-linear: waves with |q| > %g /mm act on the others and these on them, not on each other\n",
                    scene.model.approximation.quasi_linear_above);
    std::printf("coefficients\n");
    for (const physics::CoefficientValue& one : e.coefficients)
        std::printf("  %-21s %-11s = %s %s\n", one.key.c_str(), one.symbol.c_str(), one.value.c_str(),
                    one.unit.c_str());
    std::printf("stepper %s, order %s%d: %s\n", stepper.name.c_str(), stepper.needs_tolerance ? "1 to " : "",
                stepper.order, stepper.citation.c_str());
    print_transforms(e);
    const char* division = stepper.needs_tolerance ? ", which does not limit the steps of the method"
                                                   : ", each divided as time.tolerance requires";
    std::printf("  %lld steps of dt = %g s%s; dt |s|max = %.3g for the linear terms (%s)\n",
                static_cast<long long>(e.cost.steps), scene.time.dt,
                scene.time.tolerance > 0.0 && (e.is_nonlinear || !stepper.is_exponential) ? division : "",
                scene.time.dt * e.fastest_rate, stepper.is_exponential ? "exact for any dt" : "implicit");
    const char* state = e.is_nonlinear ? "the isotropic state is " : "";
    if (e.growth.rate > 0.0)
        std::printf("  %sunstable: a mode grows at %.4g /s at |q| = %.3g /mm, by a factor e^%.3g in this run%s\n",
                    state, e.growth.rate, e.growth.q, e.growth.rate * scene.time.end, e.limit_of_growth.c_str());
    else if (e.growth.rate == 0.0)
        std::printf("  %sneutral: a mode neither grows nor decays at |q| = %.3g /mm\n", state, e.growth.q);
    else
        std::printf("  %sstable: the slowest mode decays at %.4g /s at |q| = %.3g /mm\n", state, -e.growth.rate,
                    e.growth.q);
    if (!e.beyond_growth.empty())
        std::printf(
            "  this leaves out %s, which depend on direction, position or time, have no derivative, or are explicit: "
            "see "
            "drover stability\n",
            joined(e.beyond_growth).c_str());
    print_cost(scene, e.cost, "on a smaller grid");
}
}  // namespace

void add_explain(CLI::App& program, Action& action) {
    struct Options : SceneOptions {
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand(
        "explain", "Describe a scene and its cost: fields and terms, or particles; memory, disk, wall time");
    add_scene_options(*command, *options);
    add_output_options(*command, *options);
    command->add_flag("--json", options->json, "Print as JSON");
    command->callback([options, &action] {
        action = [options]() -> int {
            const io::Scene scene = run::with_chosen_step(scene_of(*options), options->json);
            if (scene.kind == io::SceneKind::model)
                return print_result(run::explain_model(scene), {.json = options->json}, scene, 1);
            if (options->json) {
                print_json(run::explanation_json(scene));
                return run::exit_done;
            }
            if (scene.kind == io::SceneKind::particles) {
                print_particles(scene, run::explain_particles(scene));
                return run::exit_done;
            }
            print_explanation(scene, run::explain_fields(scene));
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
