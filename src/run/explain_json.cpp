// run/explain_json.cpp: an explanation as JSON.
#include <nlohmann/json.hpp>

#include "drover/dem/bodies.hpp"
#include "drover/run/explain.hpp"
#include "drover/run/model_explain.hpp"
#include "drover/run/step_choice.hpp"
#include "run/json.hpp"

namespace drover::run {

namespace {
nlohmann::json cost_json(const io::Scene& scene, const Cost& cost) {
    const auto seconds = [&](double ExpectedTime::*part) {
        return cost.time ? nlohmann::json(*cost.time.*part) : nlohmann::json();
    };
    return {{"steps", cost.steps},
            {"threads", cost.threads},
            {"seconds_per_step_estimate", seconds(&ExpectedTime::step)},
            {"seconds_estimate", seconds(&ExpectedTime::total)},
            {"memory_bytes", cost.needs.memory_bytes},
            {"disk_bytes", cost.needs.disk_bytes},
            {"archive", archive_path(scene).string()}};
}

/// Counts per step; null where they vary.
nlohmann::json per_step(const FieldExplanation& e, int each) {
    return e.is_nonlinear && e.stages == 0 ? nlohmann::json() : nlohmann::json(e.stages * each);
}

nlohmann::json explanation_json(const io::Scene& scene, const FieldExplanation& e) {
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

nlohmann::json supply_json(const Supply& supply) {
    return {{"count", supply.count},
            {"area_fraction", supply.area_fraction},
            {"shapes", supply.shapes},
            {"mass", {supply.min_mass, supply.max_mass}},
            {"length", {supply.min_length, supply.max_length}}};
}

nlohmann::json explanation_json(const io::Scene& scene, const ParticleExplanation& e) {
    nlohmann::json result{{"kind", "particles"},
                          {"beads", supply_json(e.beads)},
                          {"rods", supply_json(e.rods)},
                          {"spheres", e.spheres},
                          {"cell", scene.particles.cell.shape},
                          {"cell_area", dem::area(scene.particles.cell)},
                          {"acceleration", e.acceleration},
                          {"steps_per_period", e.steps_per_period}};
    result.update(cost_json(scene, e.cost));
    return result;
}
}  // namespace

nlohmann::json explanation_json(const io::Scene& scene) {
    switch (scene.kind) {
        case io::SceneKind::fields: return explanation_json(scene, explain_fields(scene));
        case io::SceneKind::particles: return explanation_json(scene, explain_particles(scene));
        case io::SceneKind::model: break;
    }
    nlohmann::json result{{"kind", "model"}};
    result.update(result_json(explain_model(scene)));
    return result;
}

}  // namespace drover::run
