// app/explain.cpp: drover explain SCENE.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/numerics/time_method.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/right_hand_side.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/run_scene.hpp"
#include "drover/run/step_choice.hpp"
#include "explain_cost.hpp"

namespace drover::app {

namespace {
struct Explanation {
    std::string form;
    std::vector<physics::Component> fields;
    std::vector<physics::ActiveTerm> terms;
    std::vector<std::string> without_degree;  ///< terms whose products have no finite degree
    std::vector<std::string> beyond_growth;   ///< terms that the growth rate leaves out
    std::vector<physics::CoefficientValue> coefficients;
    physics::FastestGrowth growth;
    double fastest_rate = 0.0;  ///< |s|max [1/s]
    Cost cost;
    physics::TransformCount transforms;  ///< per right-hand side
    bool is_nonlinear = false;
    int stages = 0;               ///< right-hand sides per step; 0 when every term is linear, or when they vary
    std::string limit_of_growth;  ///< what may stop the growth of order
    int degree = 1;               ///< of the products
    int kept_x = 0, kept_y = 0;   ///< the largest mode number kept on each axis
};

/// The largest k with k (degree + 1) < points.
int largest_kept(int points, int degree) { return (points - 1) / (degree + 1); }

/// Right-hand sides of one step; 0: they vary.
int stages_of(const io::Scene& scene) {
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    return scene.time.tolerance > 0.0 ? method.stages_with_tolerance : method.stages;
}

std::vector<std::string> terms_without_degree(const physics::Equations& equations) {
    std::vector<std::string> names;
    for (const physics::Term& term : equations.active)
        if (!physics::point_cost(equations, term).has_finite_degree) names.push_back(term.name);
    return names;
}

std::string limit_of_growth(const physics::Equations& equations) {
    if (equations.saturation.is_active()) return " until relaxation.saturation limits it";
    return equations.model.text_terms.empty() ? "; no term saturates it" : " unless a term written as text limits it";
}

Explanation explain(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    const numerics::System system = physics::linear_system(scene.model, scene.grid, scene.dealiasing);
    return {.form = physics::form_name(equations.form),
            .fields = physics::component_names(equations.form),
            .terms = physics::active_terms(equations),
            .without_degree = terms_without_degree(equations),
            .beyond_growth = physics::terms_beyond_propagator(equations),
            .coefficients = physics::coefficient_values(scene.model),
            .growth = physics::fastest_growth(system),
            .fastest_rate = physics::fastest_rate(system),
            .cost = cost_of(scene),
            .transforms = physics::transform_count(equations),
            .is_nonlinear = physics::is_nonlinear(equations),
            .stages = physics::is_nonlinear(equations) ? stages_of(scene) : 0,
            .limit_of_growth = limit_of_growth(equations),
            .degree = system.degree,
            .kept_x = largest_kept(scene.grid.nx, system.degree),
            .kept_y = largest_kept(scene.grid.ny, system.degree)};
}

/// Counts per step; null where they vary.
nlohmann::json per_step(const Explanation& e, int each) {
    return e.is_nonlinear && e.stages == 0 ? nlohmann::json() : nlohmann::json(e.stages * each);
}

nlohmann::json explanation_json(const io::Scene& scene, const Explanation& e) {
    nlohmann::json fields = nlohmann::json::array(), terms = nlohmann::json::array();
    for (const physics::Component& field : e.fields) fields.push_back({{"name", field.name}, {"unit", field.unit}});
    for (const physics::ActiveTerm& term : e.terms) terms.push_back({{"name", term.name}, {"equation", term.equation}});
    nlohmann::json coefficients = nlohmann::json::array();
    for (const physics::CoefficientValue& one : e.coefficients)
        coefficients.push_back({{"key", one.key}, {"symbol", one.symbol}, {"value", one.value}, {"unit", one.unit}});
    nlohmann::json result{{"form", e.form},
                          {"fields", fields},
                          {"terms", terms},
                          {"terms_without_degree", e.without_degree},
                          {"coefficients", coefficients},
                          {"transforms_per_right_hand_side",
                           {{"inverse", e.transforms.inverse}, {"forward", e.transforms.forward}}},
                          {"right_hand_sides_per_step", per_step(e, 1)},
                          {"transforms_per_step", per_step(e, e.transforms.inverse + e.transforms.forward)},
                          {"degree", e.degree},
                          {"largest_mode_kept", {{"x", e.kept_x}, {"y", e.kept_y}}},
                          {"fastest_rate", e.fastest_rate},
                          {"dt_times_fastest_rate", scene.time.dt * e.fastest_rate},
                          {"growth_rate", e.growth.rate},
                          {"growth_wavenumber", e.growth.q},
                          {"growth_leaves_out", e.beyond_growth}};
    result.update(cost_json(scene, e.cost));
    return result;
}

void print_transforms(const Explanation& e) {
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

void print(const io::Scene& scene, const Explanation& e) {
    const numerics::TimeMethod& stepper = numerics::time_method(scene.time.stepper);
    std::printf("form: %s\n", e.form.c_str());
    std::printf("fields on %d by %d points, %g by %g mm\n", scene.grid.nx, scene.grid.ny, scene.grid.lx, scene.grid.ly);
    for (const physics::Component& field : e.fields)
        std::printf("  %-16s %-9s %s\n", field.name.c_str(), ("[" + field.unit + "]").c_str(), field.meaning.c_str());
    std::printf("terms\n");
    for (const physics::ActiveTerm& term : e.terms)
        std::printf("  %-21s %s\n", term.name.c_str(), term.equation.c_str());
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
        std::printf("  this leaves out %s, which depend on direction, position or time: see drover stability\n",
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
        action = [options] {
            const io::Scene scene = run::with_chosen_step(scene_of(*options), options->json);
            if (scene.kind == io::SceneKind::particles) {
                explain_particles(scene, options->json);
                return run::exit_done;
            }
            const Explanation explanation = explain(scene);
            if (options->json) print_json(explanation_json(scene, explanation));
            else print(scene, explanation);
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
