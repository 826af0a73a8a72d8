// physics/text_terms.cpp: the equations of which the terms of a scene are, and what a form admits.
#include "text_terms.hpp"

#include <algorithm>

#include "program_functions.hpp"
#include "term_names.hpp"

namespace drover::physics {

namespace {
/// Throws an input Error if the model does not have the equation.
const TermTarget& target_of(const CompiledModel& model, const TextTerm& written) {
    const auto& targets = term_targets;
    const auto* target =
        std::find_if(targets.begin(), targets.end(), [&](const TermTarget& t) { return written.of == t.of; });
    require(target != targets.end(), written.where,
            "of = \"{}\"; expected one of bead_density, rod_density, bead_velocity, order: the field of the equation",
            written.of);
    require(has_field(model.form, target->symbol), written.where,
            "of = \"{}\", a field that this model excludes; include the field in [fields], or remove the term",
            written.of);
    return *target;
}

SceneTerm text_term(const TextTerm& written, const TermTarget& target,
                    const std::shared_ptr<const model::Scope>& scope) {
    const bool is_flux = !written.flux.empty();
    require(is_flux != !written.value.empty(), written.where, "expected either value or flux in a term, {}",
            is_flux ? "found both" : "found neither");
    require(!is_flux || target.is_scalar, written.where, "only a density has a flux; of = \"{}\" needs a value",
            written.of);
    const std::vector<WrittenExpression>& texts = is_flux ? written.flux : written.value;
    const std::size_t expected = target.is_scalar && !is_flux ? 1 : 2;
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

SceneTerm function_term(const CompiledModel& model, const TextTerm& written, const TermTarget& target,
                        std::size_t number) {
    const ProgramFunction call = program_function(model, written, number);
    const auto scope = std::make_shared<model::Scope>();
    scope->names = argument_names(model.form);
    scope->parameters = model.model.parameters;
    scope->functions = {{"function", given_function(call)}};
    return {.field = target.symbol,
            .equation = text(target.is_scalar ? "-div of the Python function {}({}), linearised by differences"
                                              : "the Python function {}({}), linearised by differences",
                             written.function, joined(written.arguments)),
            .written = {.texts = {{text("function({})", joined(written.arguments)), written.where}},
                        .is_flux = target.is_scalar,
                        .scope = scope}};
}
}  // namespace

std::vector<SceneTerm> scene_terms(const CompiledModel& model) {
    std::vector<SceneTerm> terms;
    if (model.model.text_terms.empty()) return terms;
    const auto scope = std::make_shared<model::Scope>();
    scope->names = text_names(model.form);
    scope->parameters = model.model.parameters;
    for (std::size_t n = 0; n < model.model.text_terms.size(); ++n) {
        const TextTerm& written = model.model.text_terms[n];
        const TermTarget& target = target_of(model, written);
        terms.push_back(written.function.empty() ? text_term(written, target, scope)
                                                 : function_term(model, written, target, n + 1));
        terms.back().written.name = text("terms[{}]", n + 1);
        terms.back().written.is_explicit = written.is_explicit;
    }
    return terms;
}

void check_admissible(const CompiledModel& model, const TextTerm& term, const model::TermSummary& summary,
                      bool is_isotropic, int velocity, bool pointwise_velocity) {
    const SourceLocation& where = term.where;
    const std::string name =
        term.function.empty() ? summary.text : text("{}, the Python function {}", summary.text, term.function);
    const bool is_density = term.of == "bead_density" || term.of == "rod_density";
    require(!is_density || summary.vanishes_when_uniform, where,
            "{} changes the number of {} in a uniform state, which the equations conserve; use a flux", name,
            term.of == "bead_density" ? "beads" : "rods");
    if (model.form.velocity != Velocity::slaved) return;
    const auto has_velocity = [velocity](const std::vector<int>& components) {
        return std::any_of(components.begin(), components.end(),
                           [velocity](int k) { return k == velocity || k == velocity + 1; });
    };
    const bool is_force = term.of == "bead_velocity";
    require(!is_force || !term.is_explicit, where,
            "{}: explicit = true, and a slaved velocity balances its forces at every instant; expected "
            "fields.bead_velocity = \"dynamic\", or explicit = false",
            name);
    require(!is_force || !has_velocity(summary.reads), where,
            "{}: a force that depends on the bead velocity needs fields.bead_velocity = \"dynamic\"; a slaved velocity "
            "balances forces with drag.coefficient only",
            name);
    const bool viscous = model.model.viscosity.shear != 0.0 || model.model.viscosity.bulk != 0.0;
    require(!viscous || !is_force || (summary.is_linear && is_isotropic), where,
            "{}: a slaved velocity with viscosity allows only linear isotropic forces; set viscosity.shear and "
            "viscosity.bulk to 0, or set fields.bead_velocity = \"dynamic\"",
            name);
    require(!has_velocity(summary.derives) || !pointwise_velocity, where,
            "{}: derivatives of a slaved velocity are not available when it depends on the densities at each point; "
            "set fields.bead_velocity = \"dynamic\"",
            name);
}

}  // namespace drover::physics
