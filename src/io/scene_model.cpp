// io/scene_model.cpp: model sections and text terms between TOML tables and a Model.
#include <algorithm>

#include "base/mapped.hpp"
#include "io/scene_parts.hpp"
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

}  // namespace drover::io
