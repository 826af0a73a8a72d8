// physics/written_model.cpp: the terms, numbers and functions of a model of a model file; the terms that a scene adds.
#include "physics/written_model.hpp"

#include <algorithm>

#include "base/mapped.hpp"
#include "physics/program_functions.hpp"

namespace drover::physics {

namespace {
/// Throws an input Error if the model does not have the equation.
const FieldRow& target_of(const CompiledModel& model, const TextTerm& written) {
    const std::vector<FieldRow>& fields = model.model.file->fields;
    const auto target = std::ranges::find_if(fields, [&](const FieldRow& one) { return written.of == one.alias; });
    require(target != fields.end(), written.where, "of = \"{}\"; expected one of {}: the field of the equation",
            written.of, joined(mapped(fields, &FieldRow::alias)));
    require(presence(model.model, *target) != Presence::absent, written.where,
            "of = \"{}\", a field that this model excludes; include the field in [fields], or remove the term",
            written.of);
    return *target;
}

SceneTerm text_term(const TextTerm& written, const FieldRow& target, const std::shared_ptr<const model::Scope>& scope) {
    const bool is_flux = !written.flux.empty();
    require(is_flux != !written.value.empty(), written.where, "expected either value or flux in a term, {}",
            is_flux ? "found both" : "found neither");
    require(!is_flux || target.spin == 0, written.where, "only a density has a flux; of = \"{}\" needs a value",
            written.of);
    const std::vector<model::Text>& texts = is_flux ? written.flux : written.value;
    const std::size_t expected = target.spin == 0 && !is_flux ? 1 : 2;
    require(texts.size() == expected, written.where, "{} has {} expressions; expected {}", is_flux ? "flux" : "value",
            texts.size(), expected == 1 ? "one, for a density" : "two, the x and y components");
    const std::vector<std::string> shown = mapped(texts, &model::Text::text);
    return {.field = target.symbol,
            .equation = text(is_flux            ? "-div({})"
                             : shown.size() > 1 ? "({})"
                                                : "{}",
                             joined(shown)),
            .written = {.texts = texts, .is_flux = is_flux, .scope = scope}};
}

SceneTerm function_term(const CompiledModel& model, const TextTerm& written, const FieldRow& target,
                        std::size_t number) {
    const ProgramFunction call = program_function(model, written, number);
    const auto scope = std::make_shared<model::Scope>();
    scope->names = argument_names(model.model);
    scope->parameters = model.model.parameters;
    scope->functions = {{"function", given_function(call)}};
    return {.field = target.symbol,
            .equation = text(target.spin == 0 ? "-div of the Python function {}({}), linearised by differences"
                                              : "the Python function {}({}), linearised by differences",
                             written.function, joined(written.arguments)),
            .written = {.texts = {{text("function({})", joined(written.arguments)), written.where}},
                        .is_flux = target.spin == 0,
                        .scope = scope}};
}

/// Of terms whose key is no coefficient, too.
bool is_active(const CompiledModel& m, const TermRow& term) {
    const ModelFile& file = *m.model.file;
    if (const auto found = m.coefficients.find(term.key); found != m.coefficients.end())
        return found->second.is_active() && has_fields(m.model, coefficient_row(term.key, file).needs);
    if (!term.on.empty())
        return std::ranges::any_of(term.on, [&](const std::string& key) { return !is_standard(m.model, key); });
    return has_fields(m.model, term.needs);
}

model::GivenFunction function_of(const Coefficient& coefficient) {
    const std::shared_ptr<const numerics::SplineTable> table = coefficient.table();
    return {.arguments = 2,
            .degree = coefficient.degree(),
            .values =
                [table](std::size_t size, std::span<const PointArgument> at, std::span<double* const> out) {
                    const auto argument = [&](std::size_t a, std::size_t i) {
                        return at[a].values ? at[a].values[i] : at[a].number;
                    };
                    for (std::size_t i = 0; i < size; ++i) out[0][i] = table->at(argument(0, i), argument(1, i)).value;
                },
            .slopes =
                [table](std::span<const double> at) {
                    const numerics::TableValue found = table->at(at[0], at[1]);
                    return std::vector<double>{found.by_first, found.by_second};
                }};
}

/// "rho, sigma": the arguments of tables.
std::string arguments_of(const ModelFile& file) { return joined(mapped(densities(file), &FieldRow::symbol)); }

void add_coefficients(const CompiledModel& m, model::Model& result) {
    const ModelFile& file = *m.model.file;
    for (const CoefficientRow& row : file.coefficients) {
        if (!row.noise_of.empty()) continue;
        const Coefficient& c = m.coefficient(row.key());
        if (c.table()) {
            result.functions["tabulated_" + row.symbol] = function_of(c);
            result.definitions.push_back({row.symbol, {text("tabulated_{}({})", row.symbol, arguments_of(file)), {}}});
        } else if (c.varies()) {
            result.definitions.push_back({row.symbol, {c.text_of(), {}}});
        } else {
            result.coefficients[row.symbol] = c.at({});
        }
    }
    for (const FieldRow* field : densities(file))
        if (presence(m.model, *field) == Presence::absent)
            result.coefficients[field->symbol] = number(m.model, field->reference);
}

/// A vector that is the same everywhere, or a source at a point.
void add_source(const ModelValues& model, model::Model& result) {
    const SourceRow& source = model.file->source;
    const auto value = [&](const char* name) { return number(model, source.section + "." + name); };
    const bool is_used = std::ranges::any_of(model.file->fields, [&](const FieldRow& field) {
        return presence(model, field) != Presence::absent &&
               std::ranges::any_of(field.terms, [&](const TermRow& term) { return term.key == source.section; });
    });
    if (source_kind(model) != SourceKind::point || !is_used) {
        result.definitions.push_back({source.symbol, {text("{0}_x e_x + {0}_y e_y", source.section), {}}});
        return;
    }
    result.fields.push_back({.name = source.section,
                             .symbol = source.symbol,
                             .spin = 1,
                             .left = model::LeftSide::given,
                             .source = {.x = value("x"),
                                        .y = value("y"),
                                        .at_x = value("at_x"),
                                        .at_y = value("at_y"),
                                        .velocity_x = value("velocity_x"),
                                        .velocity_y = value("velocity_y"),
                                        .width = value("width")}});
}

/// What the names in the formulas stand for, besides the fields.
void add_names(const CompiledModel& m, model::Model& result) {
    const ModelFile& file = *m.model.file;
    add_coefficients(m, result);
    for (const auto& [name, key] : file.numbers) result.coefficients[name] = number(m.model, key);
    for (const DefinitionRow& row : file.definitions)
        for (const auto& [chosen, formula] : row.formulas)
            if (row.by.empty() || chosen == word(m.model, row.by))
                result.definitions.push_back({row.name, {formula, {}}});
    add_source(m.model, result);
}

/// What an equation has besides its terms.
model::Field field_of(const CompiledModel& m, const FieldRow& row, Written as) {
    model::Field field{.name = row.name,
                       .symbol = row.symbol,
                       .spin = row.spin,
                       .unit = unit_of(m.model, row.unit),
                       .meaning = row.meaning,
                       .observed = row.observed};
    if (!row.reference.empty()) field.reference = number(m.model, row.reference);
    field.conserved = row.conserved;
    if (as == Written::right_sides) return field;
    if (presence(m.model, row) == Presence::balance) field.left = model::LeftSide::balance;
    else {
        field.mass = {row.mass, {}};
        field.noise = number(m.model, row.noise);
        field.noise_conserves = row.conserved;
    }
    return field;
}

/// Whether two models have the same terms in the same form.
bool has_same_terms(const ModelValues& a, const ModelValues& b) {
    const std::vector<const FieldRow*> means = densities(*a.file);
    const bool has_densities =
        std::ranges::all_of(means, [&](const FieldRow* field) { return presence(a, *field) != Presence::absent; });
    const auto may_differ = [&](const KeyRow& row) {
        return std::ranges::any_of(means, [&](const FieldRow* field) {
            return row.key() == field->area || (has_densities && row.key() == field->reference);
        });
    };
    const auto factors = [&](const KeyRow& row) {  // their coefficients are compared
        return std::ranges::any_of(a.file->coefficients,
                                   [&](const CoefficientRow& one) { return one.factor_key == row.key(); });
    };
    return a.text_terms.empty() && b.text_terms.empty() && std::ranges::all_of(a.file->keys, [&](const KeyRow& row) {
               return may_differ(row) || factors(row) || a.values.at(row.key()) == b.values.at(row.key());
           });
}
}  // namespace

std::vector<SceneTerm> scene_terms(const CompiledModel& model) {
    std::vector<SceneTerm> terms;
    if (model.model.text_terms.empty()) return terms;
    const auto scope = std::make_shared<model::Scope>();
    scope->names = text_names(model.model);
    scope->parameters = model.model.parameters;
    for (std::size_t n = 0; n < model.model.text_terms.size(); ++n) {
        const TextTerm& written = model.model.text_terms[n];
        const FieldRow& target = target_of(model, written);
        terms.push_back(written.function.empty() ? text_term(written, target, scope)
                                                 : function_term(model, written, target, n + 1));
        terms.back().written.name = text("terms[{}]", n + 1);
        terms.back().written.is_explicit = written.is_explicit;
    }
    return terms;
}

WrittenModel write_model(const CompiledModel& m, Written as) {
    WrittenModel result;
    const std::vector<SceneTerm> of_scene = scene_terms(m);
    for (const FieldRow& row : m.model.file->fields) {
        if (presence(m.model, row) == Presence::absent) continue;
        model::Field field = field_of(m, row, as);
        for (const TermRow& term : row.terms) {
            if (!is_active(m, term)) continue;
            if (!field.equation.text.empty()) field.equation.text += term.formula[0] == '-' ? " " : " + ";
            field.equation.text += term.formula;
            result.terms.push_back(term.key);
        }
        for (const SceneTerm& term : of_scene) {
            if (term.field != row.symbol) continue;
            field.further.push_back(term.written);
            result.terms.push_back(term.written.name);
            // Texts that are no fluxes are checked in a uniform state alone.
            if (!term.written.is_flux) field.conserved = false;
        }
        result.model.fields.push_back(std::move(field));
    }
    add_names(m, result.model);
    return result;
}

std::optional<std::map<std::string, double>> ratios_of_terms(const CompiledModel& m, const CompiledModel& to) {
    if (!has_same_terms(m.model, to.model)) return {};
    std::map<std::string, double> ratios;
    for (const CoefficientRow& row : m.model.file->coefficients) {
        const Coefficient &before = m.coefficient(row.key()), &now = to.coefficient(row.key());
        if (before == now || !row.noise_of.empty()) continue;
        const bool is_of_term = !row.needs.empty();  // a mass is none
        if (before.varies() || now.varies() || !is_of_term) return {};
        const double was = before.at({}), is = now.at({});
        if (was == 0.0 || is == 0.0) return {};
        ratios[row.key()] = is / was;
    }
    return ratios;
}

std::string key_of_term(const std::string& symbol, const std::string& factor) {
    for (const FieldRow& field : shipped_model().fields)
        for (const TermRow& term : field.terms)  // of one coefficient: "-b |p|^2 p"
            if (field.symbol == symbol && term.formula.ends_with(" " + factor) &&
                term.formula.find(' ') == term.formula.size() - factor.size() - 1)
                return term.key;
    return "";
}

std::vector<HeldRange> held_ranges(const TableData& table) {
    std::vector<HeldRange> ranges;
    if (!table.has_values() || table.outside != numerics::Outside::hold) return ranges;
    const std::vector<const FieldRow*> fields = densities();
    for (std::size_t k = 0; k < fields.size(); ++k)
        if (const std::vector<double>& nodes = table.nodes[k]; nodes.size() > 1)
            ranges.push_back({.symbol = fields[k]->symbol, .min = nodes.front(), .max = nodes.back()});
    return ranges;
}

}  // namespace drover::physics
