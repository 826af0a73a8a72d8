// physics/model_keys.cpp: the keys of a scene, from the rows of its model file.
#include "physics/model_keys.hpp"

#include <algorithm>

namespace drover::physics {

namespace {
using Texts = std::vector<std::string>;

ModelKey value_key(const std::string& section, Description description, bool is_number) {
    const std::string key = section + "." + description.name;
    return {.description = std::move(description),
            .get = [key](const ModelValues& model) { return model.values.at(key); },
            .set = [key](ModelValues& model, const Value& value) { model.values[key] = value; },
            .is_number = is_number};
}

// Descriptions are made apart: GCC 12 destroys the members of a nested aggregate twice when memory runs out within it.
ModelKey coefficient_key(const CoefficientRow& row) {
    Description description{.name = row.name(),
                            .default_value = row.standard,
                            .unit = row.unit,
                            .range = row.range,
                            .choices = {},
                            .doc = row.symbol + ": " + row.doc};
    return value_key(row.section(), std::move(description), true);
}

std::string example_monomial(const ModelFile& file) {
    const std::vector<const FieldRow*> fields = densities(file);
    return text("-0.5 {} {}^2", fields.front()->symbol, fields.back()->symbol);
}

ModelKey monomials_key(const CoefficientRow& row, const ModelFile& file) {
    Description description{.name = row.name() + "_terms",
                            .default_value = Texts{},
                            .unit = {},
                            .range = {},
                            .choices = {},
                            .doc = text("monomials in the densities added to the coefficient, such as \"{}\"",
                                        example_monomial(file))};
    return {.description = std::move(description),
            .get = [key = row.key()](const ModelValues& model) -> Value { return monomials_of(model, key); },
            .set = [key = row.key()](ModelValues& model,
                                     const Value& value) { model.monomials[key] = std::get<Texts>(value); }};
}

ModelKey list_key(const std::string& name, const std::string& unit, const Range& range, const std::string& doc,
                  std::function<std::vector<double>&(ModelValues&)> list) {
    Description description{
        .name = name, .default_value = std::vector<double>{}, .unit = unit, .range = range, .choices = {}, .doc = doc};
    return {.description = std::move(description),
            .get = [list](const ModelValues& model) -> Value {
                ModelValues copy = model;  // a list makes a column where there is none
                return list(copy);
            },
            .set = [list](ModelValues& model,
                          const Value& value) { list(model) = std::get<std::vector<double>>(value); }};
}

/// A density in the units of its reference, as scenes write it.
std::string unit_of_mean(const FieldRow& field, const ModelFile& file) {
    for (const KeyRow& row : file.keys)
        if (row.key() == field.reference) return row.description.unit;
    return field.unit;
}

std::vector<ModelKey> table_keys(const ModelFile& file) {
    constexpr const char* errors = "standard errors of these values, independent of each other; for drover boundary";
    std::vector<ModelKey> keys;
    const std::vector<const FieldRow*> fields = densities(file);
    for (std::size_t k = 0; k < fields.size(); ++k) {
        keys.push_back(list_key(fields[k]->name, unit_of_mean(*fields[k], file), any_number,
                                text("nodes of the {} {}, ascending; empty: no dependence on it",
                                     words_of(fields[k]->name), fields[k]->symbol),
                                [k](ModelValues& m) -> std::vector<double>& { return m.table.nodes[k]; }));
    }
    const std::string values =
        text("at each node, {} fastest; replaces the coefficient in its section", words_of(fields.back()->name));
    for (const bool error : {false, true})
        for (const CoefficientRow& row : file.coefficients)
            if (row.varies)
                keys.push_back(list_key(row.section() + "_" + row.name() + (error ? "_error" : ""), row.unit,
                                        error ? not_negative : any_number, error ? errors : values,
                                        [key = row.key(), error](ModelValues& m) -> std::vector<double>& {
                                            TableColumn& column = m.table.columns[key];
                                            return error ? column.errors : column.values;
                                        }));
    Description outside{.name = "outside",
                        .default_value = std::string(drover::name_of(numerics::Outside::refuse)),
                        .unit = {},
                        .range = {},
                        .choices = all_names<numerics::Outside>(),
                        .doc =
                            "densities beyond the nodes: refuse: stop with an error; hold: use the values at the edge"};
    keys.push_back({.description = std::move(outside),
                    .get = [](const ModelValues& m) -> Value { return std::string(drover::name_of(m.table.outside)); },
                    .set =
                        [](ModelValues& m, const Value& value) {
                            m.table.outside = value_named<numerics::Outside>(std::get<std::string>(value)).value();
                        }});
    return keys;
}

bool is_mean(const std::string& key, const ModelFile& file) {
    const std::vector<const FieldRow*> fields = densities(file);
    return std::ranges::any_of(fields, [&](const FieldRow* field) { return field->reference == key; });
}

const std::string* doc_of_section(const std::string& name, const ModelFile& file) {
    for (const auto& [section, doc] : file.sections)
        if (section == name) return &doc;
    return nullptr;
}

/// What a term has besides its coefficient: a formula that a key chooses, or a vector of a section of its own.
std::vector<CoefficientValue> named_parts(const ModelValues& model, const TermRow& term) {
    const ModelFile& file = *model.file;
    std::vector<CoefficientValue> result;
    for (const DefinitionRow& row : file.definitions) {
        if (row.by.empty() || term.formula.find(row.name) == std::string::npos || number(model, term.key) == 0.0)
            continue;
        for (const auto& [chosen, formula] : row.formulas)
            if (chosen == word(model, row.by))
                result.push_back(
                    {row.by, row.name, formula, "", *doc_of_section(row.by.substr(0, row.by.find('.')), file)});
    }
    const std::string* doc = doc_of_section(term.key, file);
    const bool is_on = std::ranges::any_of(term.on, [&](const std::string& key) { return !is_standard(model, key); });
    if (doc == nullptr || !is_on) return result;
    std::string value = text("({}, {})", number(model, term.key + ".x"), number(model, term.key + ".y"));
    std::string unit;
    for (const KeyRow& row : file.keys)
        if (row.key() == term.key + ".x") unit = row.description.unit;
    if (term.key == file.source.section) {
        const SourceKind kind = source_kind(model);
        value += text(", {}", kind);
        unit = kind == SourceKind::point ? file.source.point_unit : file.source.unit;
    }
    result.push_back({term.key, term.formula, value, unit, *doc});
    return result;
}
}  // namespace

std::vector<ModelSection> model_sections(const ModelFile& file) {
    std::vector<ModelSection> sections;
    for (const auto& [name, doc] : file.sections) {
        ModelSection section{.name = name, .doc = doc, .keys = {}};
        for (const CoefficientRow& row : file.coefficients) {
            if (row.section() != name) continue;
            section.keys.push_back(coefficient_key(row));
            if (row.varies) section.keys.push_back(monomials_key(row, file));
        }
        for (const KeyRow& row : file.keys)
            if (row.section() == name)
                section.keys.push_back(value_key(name, row.description, is_mean(row.key(), file)));
        if (name == "table") section.keys = table_keys(file);
        sections.push_back(std::move(section));
    }
    return sections;
}

const std::vector<ModelSection>& model_sections() {
    static const std::vector<ModelSection> sections = model_sections(shipped_model());
    return sections;
}

const ModelKey* find_key(const std::string& key) {
    for (const ModelSection& section : model_sections())
        for (const ModelKey& one : section.keys)
            if (section.name + "." + one.description.name == key) return &one;
    return nullptr;
}

std::vector<CoefficientValue> coefficient_values(const ModelValues& model) {
    const ModelFile& file = *model.file;
    std::vector<CoefficientValue> result;
    for (const CoefficientRow& row : file.coefficients) {
        if (!has_fields(model, row.needs)) continue;
        const double constant = number(model, row.key());
        const std::vector<std::string>& monomials = monomials_of(model, row.key());
        if (row.varies && !model.table.column(row.key()).values.empty())
            result.push_back({row.key(), row.symbol, "from the table", row.unit, row.doc});
        else if (row.varies && !monomials.empty())
            result.push_back(
                {row.key(), row.symbol, text("{:.6g} + {}", constant, joined(monomials, " + ")), row.unit, row.doc});
        else if (constant != 0.0) result.push_back({row.key(), row.symbol, constant, row.unit, row.doc});
    }
    for (const FieldRow& field : file.fields)
        if (presence(model, field) != Presence::absent)
            for (const TermRow& term : field.terms)
                for (CoefficientValue& one : named_parts(model, term)) result.push_back(std::move(one));
    for (const auto& [name, value] : model.parameters)
        result.push_back({"terms." + name, name, value, "", "a parameter of the terms written as text"});
    return result;
}

std::string coefficient_documentation(const ModelFile& file) {
    const auto escaped = [](std::string words) {
        for (std::size_t at = 0; (at = words.find('|', at)) != std::string::npos; at += 2) words.insert(at, 1, '\\');
        return words;
    };
    std::string result = "| symbol | key | unit | meaning |\n|---|---|---|---|\n";
    for (const CoefficientRow& row : file.coefficients)
        result += text("| {} | `{}`{} | {} | {} |\n", row.symbol, row.key(), row.varies ? " *" : "", row.unit,
                       escaped(row.doc));
    return result;
}

}  // namespace drover::physics
