// io/scene_initial.cpp: the initial state of a scene of fields between a TOML table and a start.
#include <algorithm>

#include "base/unread_keys.hpp"
#include "io/scene.hpp"
#include "io/scene_parts.hpp"
#include "physics/model_file.hpp"

namespace drover::io {

namespace {
/// A unit of the model file as keys of a scene have it: "mm/s" for "mm s-1".
std::string unit_of_key(const std::string& unit) {
    std::string above, below;
    for (std::size_t at = 0; at < unit.size();) {
        const std::size_t end = std::min(unit.find(' ', at), unit.size());
        const std::string factor = unit.substr(at, end - at);
        const std::size_t minus = factor.find('-');
        if (minus == std::string::npos) above += (above.empty() ? "" : " ") + factor;
        else {
            const std::string power = factor.substr(minus + 1);
            below += "/" + factor.substr(0, minus) + (power == "1" ? "" : "^" + power);
        }
        at = end + 1;
    }
    return (above.empty() && !below.empty() ? "1" : above) + below;
}

/// A row for each component of rods and beads.
std::vector<Description> formula_rows() {
    std::vector<Description> rows;
    for (const physics::FieldRow& row : physics::shipped_model().fields) {
        const model::Field field = row.as_field();
        const std::vector<std::string> names = model::dataset_names(field), symbols = model::component_names(field);
        for (std::size_t part = 0; part < names.size(); ++part)
            rows.push_back({.name = names[part],
                            .default_value = std::string{},
                            .unit = unit_of_key(row.unit),
                            .doc = "formula: " + symbols[part]});
    }
    rows.front().doc += ", such as \"2 + 0.1 * exp(-((x - 8)^2 + (y - 8)^2) / 4)\", in mm; empty: uniform";
    return rows;
}

/// Behind which key the formulas of rods and beads are.
constexpr const char* before_formulas = "phase";
}  // namespace

model::Start default_start(SceneKind kind) {
    model::Start start;
    for (const physics::FieldRow& row : physics::shipped_model().fields)
        if (kind != SceneKind::model && row.perturbed) start.component = model::dataset_names(row.as_field()).front();
    return start;
}

std::vector<Description> initial_rows(SceneKind kind) {
    std::vector<Description> rows = descriptions<model::Start>();
    for (Description& row : rows)
        if (row.name == "field") row.default_value = default_start(kind).component;
    if (kind == SceneKind::model) return rows;
    const std::vector<Description> formulas = formula_rows();
    const auto before = [](const Description& row) { return row.name == before_formulas; };
    rows.insert(std::ranges::find_if(rows, before) + 1, formulas.begin(), formulas.end());
    return rows;
}

std::vector<std::pair<std::string, Value>> initial_values(const model::Start& start, SceneKind kind) {
    std::vector<std::pair<std::string, Value>> values = values_of(start);
    if (kind == SceneKind::model) {
        for (const auto& [component, formula] : start.formulas) values.emplace_back(component, formula.text);
        return values;
    }
    std::vector<std::pair<std::string, Value>> formulas;
    for (const Description& row : formula_rows()) {
        const auto found = start.formulas.find(row.name);
        formulas.emplace_back(row.name, found == start.formulas.end() ? std::string{} : found->second.text);
    }
    const auto before = [](const auto& value) { return value.first == before_formulas; };
    values.insert(std::ranges::find_if(values, before) + 1, formulas.begin(), formulas.end());
    return values;
}

void take_formulas(LocatedTable& table, Scene& scene) {
    for (const auto& [key, value] : table.values) scene.places.emplace("initial." + key, value.where);
    std::vector<Description> rows = initial_rows(scene.kind);
    for (const std::string& name : component_names(scene.declared)) {  // none of rods and beads
        rows.push_back(rows.front());
        rows.back().name = name;
    }
    reject_unknown_keys(table, "initial", rows);
    LocatedTable formulas{.where = table.where, .values = {}};
    const std::vector<Description> others = descriptions<model::Start>();
    std::erase_if(table.values, [&](const auto& one) {
        const bool is_formula = std::ranges::find(others, one.first, &Description::name) == others.end();
        if (is_formula) formulas.values.insert(one);
        return is_formula;
    });
    for (const auto& [component, formula] : texts_of(formulas, "initial"))
        if (!formula.text.empty()) scene.initial.formulas.emplace(component, formula);
}

void check_unread(const model::Start& start, SceneKind kind, const Locate& locate) {
    if (start.kind != model::StartKind::uniform) return;  // --set gives a scene another kind, and its other keys stay
    const std::string mode = "initial.kind = \"mode\"", file = "initial.kind = \"file\"";
    reject_unread(start, "initial", "initial.kind = \"uniform\"",
                  {{"amplitude", {false, "initial.kind = \"random\", \"mode\" or \"formula\""}},
                   {"field", {false, mode}},
                   {"mode_x", {false, mode}},
                   {"mode_y", {false, mode}},
                   {"phase", {false, mode}},
                   {"file", {false, file}},
                   {"frame", {false, file}}},
                  locate, default_start(kind));
}

void check_noise_of_start(const model::Start& start, const model::Equations& equations, const Locate& locate) {
    if (start.kind != model::StartKind::stationary || equations.has_noise()) return;
    std::vector<std::string> keys;
    for (const model::StateComponent& one : model::components_of_state(equations))
        for (const physics::FieldRow& row : physics::shipped_model().fields)
            if (one.part == 0 && equations.model().fields[one.field].symbol == row.symbol)
                keys.push_back(row.noise + " = 0");
    fail_input(locate("initial.kind"),
               "initial.kind = \"stationary\" with {}; a stationary state needs noise: give one of them > 0, or choose "
               "another initial.kind",
               joined(keys));
}

}  // namespace drover::io
