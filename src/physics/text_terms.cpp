// physics/text_terms.cpp: the equations of which the terms of a scene are, and what a form admits.
#include "physics/text_terms.hpp"

#include <algorithm>

#include "physics/program_functions.hpp"

namespace drover::physics {

namespace {
/// Throws an input Error if the model does not have the equation.
const FieldRow& target_of(const CompiledModel& model, const TextTerm& written) {
    const std::vector<FieldRow>& fields = model.model.file->fields;
    const auto target =
        std::find_if(fields.begin(), fields.end(), [&](const FieldRow& one) { return written.of == one.alias; });
    std::vector<std::string> names;
    for (const FieldRow& field : fields) names.push_back(field.alias);
    require(target != fields.end(), written.where, "of = \"{}\"; expected one of {}: the field of the equation",
            written.of, joined(names));
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
    const std::vector<WrittenExpression>& texts = is_flux ? written.flux : written.value;
    const std::size_t expected = target.spin == 0 && !is_flux ? 1 : 2;
    require(texts.size() == expected, written.where, "{} has {} expressions; expected {}", is_flux ? "flux" : "value",
            texts.size(), expected == 1 ? "one, for a density" : "two, the x and y components");
    SceneTerm term{.field = target.symbol, .equation = {}, .written = {.is_flux = is_flux, .scope = scope}};
    std::vector<std::string> shown;
    for (const WrittenExpression& one : texts) {
        term.written.texts.push_back({one.text, one.where});
        shown.push_back(one.text);
    }
    term.equation = text(is_flux ? "-div({})" : shown.size() > 1 ? "({})" : "{}", joined(shown));
    return term;
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

}  // namespace drover::physics
