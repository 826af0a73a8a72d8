// run/rod_bead_stability.cpp: the uniform states of rods and beads, and their effective coefficients.
#include <algorithm>

#include "drover/physics/long_waves.hpp"
#include "drover/physics/stability_rows.hpp"
#include "run/stability_problem.hpp"

namespace drover::run {

namespace {
Record coefficient_record(const physics::Equations& equations) {
    const physics::UniformState& uniform = equations.model.uniform;
    const physics::EffectiveCoefficients values =
        physics::effective_coefficients(equations, uniform.bead_density, uniform.rod_density);
    Record record{.heading = "effective coefficients"};
    for (const physics::EffectiveCoefficientRow& row : physics::effective_coefficient_rows(equations.form)) {
        record.entries.push_back(number(row.name, row.unit, row.meaning, values.*row.member));
        record.entries.back().shown.text = row.applies;
    }
    return record;
}

std::string heading_of(const physics::StationaryState& state, const physics::Equations& equations) {
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

Entry vector_entry(const char* name, const char* unit, const char* meaning, const Eigen::Vector2d& value) {
    return {.name = name, .unit = unit, .meaning = meaning, .value = std::vector<double>{value.x(), value.y()}};
}

Entry density_entry(const char* name, double value, const char* meaning, bool applies) {
    return {.name = name, .unit = "mm-2", .meaning = meaning, .value = value, .shown = {.text = applies}};
}

AnalysedState analysed(const physics::Equations& equations, const physics::StationaryState& state) {
    AnalysedState result{.name = state.name,
                         .group = "/" + state.name,
                         .heading = heading_of(state, equations),
                         .entries = {vector_entry("order", equations.form.order_is_density ? "mm-2" : "1",
                                                  "polar order p0 of the state", state.point.order),
                                     vector_entry("velocity", "mm s-1", "bead velocity of the state",
                                                  state.point.velocity)},
                         .linear = *equations.linearised(state.point),
                         .has_free_direction = state.free_direction};
    std::replace(result.group.begin(), result.group.end(), ' ', '_');
    for (const physics::StructurePart& part : physics::structure_parts(equations, physics::direction_of(state.point)))
        result.parts.push_back(
            {part.name, part.unit,
             [value = part.value](const model::Symbol& s, const numerics::Wavevector&) { return value(s); }});
    result.slow_modes = [waves = physics::long_waves(equations, state),
                         direction = physics::direction_of(state.point)](double angle) -> model::SlowModes {
        if (!waves.why_none.empty()) return {.why_none = waves.why_none};
        return {.modes = model::slow_modes(waves, direction + angle)};
    };
    return result;
}
}  // namespace

StabilityProblem rod_bead_stability(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    const physics::UniformState& uniform = scene.model.uniform;
    const physics::StationaryStates found = physics::stationary_states(equations);
    const std::vector<std::string> notes =
        physics::stability_remarks(equations, physics::effective_coefficients(equations, uniform.bead_density,
                                                                              uniform.rod_density));
    StabilityProblem problem{
        .direction = "p0",
        .entries = {words("form", "fields of the model", physics::form_name(equations.form)),
                    density_entry("bead_density", uniform.bead_density, "rho", equations.form.bead_density >= 0),
                    density_entry("rod_density", uniform.rod_density, "sigma", equations.form.rod_density >= 0),
                    {.name = "no_order", .unit = "", .meaning = "", .value = found.no_order, .shown = {false}},
                    {.name = "notes", .unit = "", .meaning = "", .value = notes, .shown = {false}}},
        .parts = {{"coefficients", coefficient_record(equations)}}};
    for (const physics::StationaryState& state : found.states) problem.states.push_back(analysed(equations, state));
    if (!found.no_order.empty()) problem.footer.push_back("\nno ordered state: " + found.no_order);
    for (const std::string& note : notes) problem.footer.push_back("\nnote: " + note);
    return problem;
}

}  // namespace drover::run
