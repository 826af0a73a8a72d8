// analysis/stability_states.cpp: the uniform states of a scene, as a stability analysis reports them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/stability_problem.hpp"
#include "calibrate/slow_order.hpp"
#include "run/scene_equations.hpp"
#include "theory/state_text.hpp"

namespace drover::analysis {

namespace {
/// Fields that observables have short names for: reported whole, in the frame of the order.
bool is_described(const model::Field& field) { return !field.observed.short_name.empty(); }
/// The order, the first that turns of the fields as they are drawn; nullptr: no field has a direction.
const model::Field* order_of(const model::Model& model) {
    for (const std::size_t n : theory::drawn_fields(model))
        if (model.fields[n].spin > 0) return &model.fields[n];
    return nullptr;
}

std::vector<run::Entry> value_entries(const model::Model& model, const model::UniformState& values) {
    std::vector<run::Entry> entries;
    std::size_t at = 0;
    for (const model::Field& field : model.fields) {
        const std::size_t first = std::exchange(at, at + static_cast<std::size_t>(model::components(field)));
        if (field.left == model::LeftSide::given || theory::is_given(field)) continue;
        if (is_described(field) && field.spin > 0) {
            entries.push_back({.name = field.observed.short_name,
                               .unit = field.unit,
                               .meaning = field.meaning + ", of the state",
                               .value = std::vector<double>{values[first], values[first + 1]}});
            continue;
        }
        std::size_t component = first;
        for (const std::string& name : model::dataset_names(field))
            entries.push_back(run::number(name, field.unit, name + " of the state", values[component++]));
    }
    return entries;
}

/// Parts of structure factors along and across q.
std::vector<StructurePart> parts_by_wave(const model::LinearisedAt& at) {
    std::vector<StructurePart> parts;
    for (const std::string& name : theory::part_names(at.equations())) {
        const auto place = static_cast<Eigen::Index>(parts.size());
        parts.push_back({name, "1", [at, place](const model::Symbol& s, const numerics::Wavevector& q) {
                             return at.along_and_across(s, q)(place, place).real();
                         }});
    }
    return parts;
}

/// Scalars, and the order along and across the direction of the state.
std::vector<StructurePart> parts_by_state(const model::LinearisedAt& at) {
    const model::Model& model = at.equations().model();
    const model::Field* const order = order_of(model);
    std::vector<StructurePart> parts;
    for (const std::size_t n : theory::drawn_fields(model)) {
        const model::Field& field = model.fields[n];
        const int x = model::first_components(model)[n], y = x + 1;
        const std::string unit = field.unit == "1" ? "mm2" : field.unit == "mm-2" ? "mm-2" : field.unit + "2 mm2";
        if (field.spin == 0)
            parts.push_back({model::short_name(field), unit,
                             [x](const model::Symbol& s, const numerics::Wavevector&) { return s(x, x).real(); }});
        if (&field != order) continue;
        for (const auto& [name, turn] : {std::pair{"along", 0.0}, std::pair{"across", 0.5 * std::numbers::pi}}) {
            const double angle = field.spin * (at.direction() + turn), c = std::cos(angle), sn = std::sin(angle);
            parts.push_back({text("{}_{}_{}0", model::short_name(field), name, field.symbol), unit,
                             [=](const model::Symbol& s, const numerics::Wavevector&) {
                                 return c * c * s(x, x).real() + sn * sn * s(y, y).real() +
                                        2.0 * c * sn * s(x, y).real();
                             }});
        }
    }
    return parts;
}

AnalysedState analysed(const io::Scene& scene, const model::Equations& equations, const theory::StationaryState& state,
                       std::size_t number_of) {
    const model::Model& model = equations.model();
    const bool is_own = scene.kind == io::SceneKind::model;
    std::string group = "/" + state.name;
    std::replace_if(
        group.begin() + 1, group.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    const std::string values = theory::values_text(model, state.values),
                      name = state.name.substr(0, state.name.find(':'));
    AnalysedState result{.name = state.name,
                         .group = is_own ? text("{}_{}", group, number_of) : group,
                         .heading = "state: " + (is_own           ? theory::state_words(model, state)
                                                 : values.empty() ? name
                                                                  : name + ", " + values),
                         .entries = value_entries(model, state.values),
                         .linear = model::LinearisedAt(equations, state.values),
                         .has_free_direction = state.has_free_direction};
    result.is_mapped_along_x = is_own && result.linear.is_isotropic();
    result.parts = is_own ? parts_by_wave(result.linear) : parts_by_state(result.linear);
    return result;
}

run::Entry row_entry(const calibrate::ResultRow& row) {
    return run::shown_as(run::number(row.name, row.unit, row.meaning, row.value), {.text = row.applies});
}

/// What only rods and beads have.
void add_slow_order(const io::Scene& scene, StabilityProblem& problem) {
    const physics::Equations equations(scene.model);
    const calibrate::SlowOrder slow = calibrate::slow_order(equations);
    const std::vector<std::string> notes = calibrate::stability_remarks(equations, slow);
    for (const calibrate::ResultRow& row : calibrate::density_rows(equations))
        problem.entries.push_back(row_entry(row));
    problem.entries.push_back(run::data_only(run::words("notes", "", notes)));
    run::Record record{.heading = "effective coefficients"};
    for (const calibrate::ResultRow& row : calibrate::slow_order_rows(equations, slow))
        record.entries.push_back(row_entry(row));
    problem.parts.emplace_back("coefficients", std::move(record));
    for (const std::string& note : notes) problem.footer.push_back("\nnote: " + note);
}
}  // namespace

StabilityProblem stability_problem(const io::Scene& scene) {
    const bool is_own = scene.kind == io::SceneKind::model;
    const model::Equations equations = run::equations_of(scene);
    const theory::StationaryStates found = run::uniform_states_of(scene, equations);
    const model::Field* const order = order_of(equations.model());
    StabilityProblem problem{.direction = order != nullptr && is_described(*order) ? order->symbol + "0" : "the order",
                             .entries = {
                                 is_own ? run::words("model", "its name", scene.declared.name)
                                        : run::words("form", "fields of the model", physics::form_name(scene.model))}};
    if (!found.why_none.empty()) problem.footer.push_back("\nno uniform stationary state: " + found.why_none);
    if (!found.kink.empty() && found.why_none.empty()) problem.footer.push_back("\nno linear theory: " + found.kink);
    if (!found.why_no_order.empty()) problem.footer.push_back("\nno ordered state: " + found.why_no_order);
    if (!is_own) add_slow_order(scene, problem);
    for (const auto& [name, why] : {std::pair{"no_state", found.why_none}, std::pair{"no_order", found.why_no_order}})
        problem.entries.push_back(run::data_only(run::words(name, "", why)));
    for (const theory::StationaryState& state : found.states)
        problem.states.push_back(analysed(scene, equations, state, problem.states.size() + 1));
    return problem;
}

}  // namespace drover::analysis
