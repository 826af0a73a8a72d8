// run/stability.cpp: the stability analysis of a scene as a result.
#include "drover/run/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/constants.hpp"
#include "drover/physics/fluctuations.hpp"
#include "drover/physics/long_waves.hpp"
#include "drover/physics/stability_rows.hpp"
#include "run/model_stability.hpp"
#include "run/stability_maps.hpp"

namespace drover::run {

namespace {
using std::numbers::pi;

Record coefficient_record(const physics::Equations& equations) {
    const physics::UniformState& uniform = equations.model.uniform;
    const physics::EffectiveCoefficients values =
        physics::effective_coefficients(equations, uniform.bead_density, uniform.rod_density);
    Record record{.heading = "effective coefficients"};
    for (const physics::EffectiveCoefficientRow& row : physics::effective_coefficient_rows(equations.form))
        record.entries.push_back({.name = row.name,
                                  .unit = row.unit,
                                  .meaning = row.meaning,
                                  .value = values.*row.member,
                                  .shown = {.text = row.applies}});
    return record;
}

Record instability_record(const physics::Instability& found) {
    const bool is_uniform = found.q == 0.0;
    return {.entries = {
                {.name = "name",
                 .unit = "",
                 .meaning = "kind of instability",
                 .value = found.name,
                 .choices = physics::instability_names(),
                 .dataset = "kind"},
                {.name = "rate", .unit = "s-1", .meaning = "largest growth rate, Re s", .value = found.rate},
                {.name = "frequency",
                 .unit = "s-1",
                 .meaning = "angular frequency of the fastest wave, -Im s",
                 .value = found.frequency},
                {.name = "wavenumber",
                 .unit = "mm-1",
                 .meaning = "|q| of the fastest wave; 0: the uniform state itself changes",
                 .value = found.q},
                {.name = "wavelength",
                 .unit = "mm",
                 .meaning = "2 pi/|q| of the fastest wave",
                 .value = is_uniform ? std::numeric_limits<double>::quiet_NaN() : 2.0 * pi / found.q},
                {.name = "angle",
                 .unit = "degree",
                 .meaning = "angle of q from p0",
                 .value = found.angle / radians_per_degree},
                {.name = "grows_from",
                 .unit = "mm-1",
                 .meaning = "smallest |q| that grows at this angle; 0: the smallest |q| searched grows",
                 .value = found.min},
                {.name = "grows_to",
                 .unit = "mm-1",
                 .meaning = "largest |q| that grows at this angle; infinite: the largest |q| searched grows",
                 .value = found.max},
                {.name = "at_longest",
                 .unit = "1",
                 .meaning = "1: the growth rate is largest at the smallest |q| searched",
                 .value = found.at_longest,
                 .shown = {.text = false}},
                {.name = "at_shortest",
                 .unit = "1",
                 .meaning = "1: the growth rate still increases at the largest |q| searched",
                 .value = found.at_shortest,
                 .shown = {.text = false}},
            }};
}

List instability_list(const std::vector<physics::Instability>& found, const model::GrowthSearch& search) {
    List list{.name = "instabilities",
              .heading = "unstable (fastest first; angles from p0; -: growth extends beyond the search)",
              .row = "instability",
              .meaning = "instabilities, fastest first",
              .prefix = "instability_",
              .empty = text("stable against all waves from |q| = {:.3g} to {:.3g} /mm", search.min, search.max)};
    for (const physics::Instability& one : found) list.rows.push_back(instability_record(one));
    return list;
}

std::vector<std::string> instability_notes(const std::vector<physics::Instability>& found) {
    std::vector<std::string> notes;
    for (const physics::Instability& one : found) {
        if (one.at_longest) notes.push_back(one.name + ": the growth rate is largest at the longest wave searched");
        if (one.at_shortest)
            notes.push_back(one.name +
                            ": the growth rate still increases at the shortest wave searched; no term of "
                            "the model stabilises short waves");
    }
    return notes;
}

/// Four angles; text has one where all directions are equivalent.
List slow_mode_list(const model::LongWaves& waves, const physics::UniformPoint& point) {
    List list{.name = "slow_modes",
              .heading = "long waves, s = -i u q - gamma q^2: u = speed + i growth, gamma = damping, angles from p0",
              .shown = {.archive = false}};
    if (!waves.why_none.empty()) return list;
    const double direction = physics::direction_of(point);
    for (const double angle : {0.0, 30.0, 60.0, 90.0})
        for (const model::SlowMode& mode : model::slow_modes(waves, direction + angle * radians_per_degree))
            list.rows.push_back(slow_mode_record(mode, angle, "p0", angle == 0.0 || !physics::is_isotropic(point)));
    return list;
}

std::string state_heading(const physics::StationaryState& state, const physics::Equations& equations) {
    std::string heading = "state: " + state.name;
    const double order = state.point.order.norm();
    if (order > 0.0) {
        heading += text(", |p| = {:.6g}", order);
        if (equations.form.order_is_density)
            heading += text(" (P = {:.4g})", order / equations.model.uniform.rod_density);
    }
    if (equations.form.velocity != physics::Velocity::absent && state.point.velocity.norm() > 0.0)
        heading += text(", |v| = {:.6g} mm/s", state.point.velocity.norm());
    return heading;
}

std::vector<double> components_of(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

Record state_record(const io::Scene& scene, const physics::Equations& equations, const physics::StationaryState& state,
                    const model::GrowthSearch& search, Threads* threads) {
    const std::vector<physics::Instability> found = physics::instabilities(equations, state, search);
    const model::LongWaves waves = physics::long_waves(equations, state);
    const double diffusion = physics::direction_diffusion(equations, state);
    std::string group = "/" + state.name;
    std::replace(group.begin(), group.end(), ' ', '_');
    Record record{
        .heading = state_heading(state, equations),
        .group = group,
        .entries = {{.name = "name", .unit = "", .meaning = "name of the state", .value = state.name, .shown = {false}},
                    {.name = "order",
                     .unit = equations.form.order_is_density ? "mm-2" : "1",
                     .meaning = "polar order p0 of the state",
                     .value = components_of(state.point.order),
                     .shown = {false}},
                    {.name = "velocity",
                     .unit = "mm s-1",
                     .meaning = "bead velocity of the state",
                     .value = components_of(state.point.velocity),
                     .shown = {false}},
                    {.name = "stable",
                     .unit = "1",
                     .meaning = "1: no wave of the search grows",
                     .value = found.empty(),
                     .shown = {false}},
                    {.name = "slow_modes_undefined", .unit = "", .meaning = "", .value = waves.why_none},
                    {.name = "direction_diffusion_times_area",
                     .unit = "rad2 mm2 s-1",
                     .meaning = "D times the area of the cell; <theta^2> = 2 D t for the direction of the mean order",
                     .value = diffusion,
                     .shown = {.text = diffusion > 0.0}}},
        .lists = {instability_list(found, search), slow_mode_list(waves, state.point)},
        .footer = instability_notes(found)};
    if (diffusion > 0.0)
        record.footer.push_back(text("in this cell the direction of the mean order diffuses with D = {:.4g} rad2 s-1",
                                     diffusion / numerics::area(scene.grid)));
    if (threads != nullptr) record.maps = stability_maps(scene, equations, state, waves, search, *threads);
    return record;
}

Entry density_entry(const char* name, double value, const char* meaning, bool applies) {
    return {.name = name, .unit = "mm-2", .meaning = meaning, .value = value, .shown = {.text = applies}};
}
}  // namespace

Result make_stability(const io::Scene& scene, Threads* threads) {
    if (scene.kind == io::SceneKind::model) return make_model_stability(scene, threads);
    const model::GrowthSearch search = growth_search(scene);
    const physics::Equations equations(scene.model);
    const physics::UniformState& uniform = scene.model.uniform;
    const physics::StationaryStates found = physics::stationary_states(equations);
    List states{.name = "states"};
    for (const physics::StationaryState& state : found.states)
        states.rows.push_back(state_record(scene, equations, state, search, threads));
    const std::vector<std::string> notes =
        physics::stability_remarks(equations, physics::effective_coefficients(equations, uniform.bead_density,
                                                                              uniform.rod_density));
    Record root{.entries = {{.name = "form",
                             .unit = "",
                             .meaning = "fields of the model",
                             .value = physics::form_name(equations.form)},
                            density_entry("bead_density", uniform.bead_density, "rho",
                                          equations.form.bead_density >= 0),
                            density_entry("rod_density", uniform.rod_density, "sigma", equations.form.rod_density >= 0),
                            {.name = "searched_from",
                             .unit = "mm-1",
                             .meaning = "smallest |q| of the search for instabilities",
                             .value = search.min},
                            {.name = "searched_to",
                             .unit = "mm-1",
                             .meaning = "largest |q| of the search for instabilities",
                             .value = search.max}},
                .parts = {{"coefficients", coefficient_record(equations)}},
                .lists = {std::move(states)}};
    root.entries.push_back({.name = "no_order", .unit = "", .meaning = "", .value = found.no_order, .shown = {false}});
    root.entries.push_back({.name = "notes", .unit = "", .meaning = "", .value = notes, .shown = {false}});
    if (!found.no_order.empty()) root.footer.push_back("\nno ordered state: " + found.no_order);
    for (const std::string& note : notes) root.footer.push_back("\nnote: " + note);
    return {.root = std::move(root)};
}

}  // namespace drover::run
