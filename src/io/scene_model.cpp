// io/scene_model.cpp: model sections, text terms and the initial state between TOML tables, a Model and a start.
#include <algorithm>

#include "base/mapped.hpp"
#include "base/unread_keys.hpp"
#include "io/scene.hpp"
#include "io/scene_parts.hpp"
#include "physics/model_file.hpp"
#include "physics/model_keys.hpp"

namespace drover::io {

namespace {
using physics::TextTerm;

std::string term_table(std::size_t number) { return text("terms[{}]", number); }

/// The texts of a key: one, or a list of them.
std::vector<model::Text> texts_of(const LocatedValue& found, const std::string& key) {
    std::vector<model::Text> result;
    const auto add = [&](const std::string& written) {
        const std::size_t n = result.size();
        result.push_back({written, n < found.items.size() ? found.items[n] : found.where});
    };
    if (const auto* one = std::get_if<std::string>(&found.value)) add(*one);
    else if (const auto* list = std::get_if<std::vector<std::string>>(&found.value)) std::ranges::for_each(*list, add);
    else
        fail_input(found.where, "{} = {}; expected an expression in quotes, or a list of two: the x and y components",
                   key, toml_text(found.value));
    return result;
}

template <class Wanted>
const Wanted& given(const LocatedValue& found, const std::string& key, const char* expected) {
    const auto* value = std::get_if<Wanted>(&found.value);
    require(value != nullptr, found.where, "{} = {}; expected {}", key, toml_text(found.value), expected);
    return *value;
}

constexpr std::int64_t max_degree = 15;  // of products that a function may declare

TextTerm read_term(const LocatedTable& table, const std::string& name) {
    TextTerm term{.of = {}, .where = table.where};
    for (const auto& [key, found] : table.values) {
        const std::string whole = name + "." + key;
        if (key == "of") {
            term.of = given<std::string>(found, whole, "the name of a field in quotes");
        } else if (key == "value") term.value = texts_of(found, whole);
        else if (key == "flux") term.flux = texts_of(found, whole);
        else if (key == "explicit") term.is_explicit = given<bool>(found, whole, "true or false");
        else if (key == parameter_names && found.where.file.empty() && found.where.line == 0)  // not of a user
            term.parameters = std::get<std::vector<std::string>>(found.value);
        else if (key == "function") term.function = given<std::string>(found, whole, "its name in quotes");
        else if (key == "source") term.source = given<std::string>(found, whole, "its text in quotes");
        else if (key == "arguments")
            term.arguments = given<std::vector<std::string>>(found, whole, "a list of names in quotes");
        else if (key == "degree") {
            const auto degree = given<std::int64_t>(found, whole, "a whole number");
            require(degree >= 0 && degree <= max_degree, found.where, "{} = {}; expected 1 to {}, or 0: not known",
                    whole, degree, max_degree);
            term.degree = static_cast<int>(degree);
        } else fail_input(found.where, "unknown key {}; expected of, value, flux, explicit or parameters", whole);
    }
    return term;
}

void read_terms(const LocatedTables& tables, physics::ModelValues& model,
                std::map<std::string, SourceLocation>& locations) {
    for (std::size_t n = 1; tables.contains(term_table(n)); ++n)
        model.text_terms.push_back(read_term(tables.at(term_table(n)), term_table(n)));
    const auto parameters = tables.find(parameter_table);
    if (parameters == tables.end()) return;
    for (const auto& [name, found] : parameters->second.values) {
        const std::string key = std::string(parameter_table) + "." + name;
        const bool known = std::ranges::any_of(model.text_terms, [&](const TextTerm& term) {
            return std::ranges::find(term.parameters, name) != term.parameters.end();
        });
        require(known, found.where, "{} is not a parameter of any [[terms]]; expected one that a term lists", key);
        const Description description{.name = name,
                                      .default_value = 0.0,
                                      .doc = "a parameter of the terms written as text"};
        model.parameters[name] = std::get<double>(checked_value(description, parameter_table, found));
        locations.emplace(key, found.where);
    }
}

WrittenTable written_term(const TextTerm& term, const std::string& name) {
    WrittenTable table{.name = name, .values = {{"of", term.of}}};
    if (!term.value.empty()) table.values.emplace_back("value", mapped(term.value, &model::Text::text));
    if (!term.flux.empty()) table.values.emplace_back("flux", mapped(term.flux, &model::Text::text));
    if (!term.function.empty())
        table.values.insert(table.values.end(), {{"function", term.function},
                                                 {"arguments", term.arguments},
                                                 {"degree", std::int64_t{term.degree}},
                                                 {"source", term.source}});
    if (term.is_explicit) table.values.emplace_back("explicit", true);
    if (!term.parameters.empty()) table.values.emplace_back(parameter_names, term.parameters);
    return table;
}

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

void read_model(const LocatedTables& tables, physics::ModelValues& model,
                std::map<std::string, SourceLocation>& locations) {
    for (const physics::ModelSection& section : physics::model_sections()) {
        const auto table = tables.find(section.name);
        if (table == tables.end()) continue;
        reject_unknown_keys(table->second, section.name, mapped(section.keys, &physics::ModelKey::description));
        for (const physics::ModelKey& key : section.keys)
            if (const auto found = table->second.values.find(key.description.name);
                found != table->second.values.end()) {
                key.set(model, checked_value(key.description, section.name, found->second));
                locations.emplace(section.name + "." + found->first, found->second.where);
            }
    }
    read_terms(tables, model, locations);
}

bool is_model_table(const std::string& name) {
    if (name == parameter_table || name.starts_with("terms[")) return true;
    const auto& sections = physics::model_sections();
    return std::ranges::any_of(sections, [&](const physics::ModelSection& section) { return section.name == name; });
}

WrittenTables written_model(const physics::ModelValues& model) {
    WrittenTables tables;
    for (const physics::ModelSection& section : physics::model_sections()) {
        tables.push_back({.name = section.name, .values = {}});
        for (const physics::ModelKey& key : section.keys)
            tables.back().values.emplace_back(key.description.name, key.get(model));
    }
    for (const TextTerm& term : model.text_terms)
        tables.push_back(written_term(term, term_table(tables.size() - physics::model_sections().size() + 1)));
    if (!model.parameters.empty())
        tables.push_back({.name = parameter_table, .values = {model.parameters.begin(), model.parameters.end()}});
    return tables;
}

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
