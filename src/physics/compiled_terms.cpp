// physics/compiled_terms.cpp: balances are solved for their fields, by wave or at each point.
#include "physics/compiled_terms.hpp"

#include <algorithm>

#include "physics/program_functions.hpp"
#include "physics/written_model.hpp"

namespace drover::physics {

int CompiledTerms::component(const std::string& symbol) const {
    for (const auto& [field, first] : model::placed_fields(right_sides.model()))
        if (field.symbol == symbol) return static_cast<int>(first);
    return -1;
}

namespace {
/// A field in balance.
struct Balance {
    const CompiledTerms& terms;
    const FieldRow& field;
    std::string name, remedy;  ///< "slaved bead velocity", what to set instead
    bool is_pointwise;

    bool has_own(const std::vector<int>& components) const {
        const int first = terms.component(field.symbol), width = field.spin == 0 ? 1 : 2;
        return std::any_of(components.begin(), components.end(),
                           [&](int k) { return k >= first && k < first + width; });
    }
};

/// The text of a scene that a term is; nullptr: a term of the file.
const TextTerm* text_of(const CompiledTerms& terms, std::size_t term) {
    const std::vector<TextTerm>& texts = terms.model.model.text_terms;
    for (std::size_t k = 0; k < texts.size(); ++k)
        if (terms.names[term] == text("terms[{}]", k + 1)) return &texts[k];
    return nullptr;
}

std::string name_of(const TextTerm& term, const model::TermSummary& summary) {
    return term.function.empty() ? summary.text : text("{}, the Python function {}", summary.text, term.function);
}

/// Of every text.
void check_conserved(const CompiledTerms& terms, const TextTerm& term, std::size_t n) {
    const model::TermSummary& summary = terms.right_sides.terms()[n];
    for (const FieldRow& field : terms.model.model.file->fields)
        require(!field.conserved || !terms.is_of(n, field) || summary.vanishes_when_uniform, term.where,
                "{} changes the number of {} in a uniform state, which the equations conserve; use a flux",
                name_of(term, summary), field.observed.short_name);
}

void check_text(const Balance& balance, const TextTerm& term, std::size_t n) {
    const model::TermSummary& summary = balance.terms.right_sides.terms()[n];
    const std::string name = name_of(term, summary);
    const bool is_own = balance.terms.is_of(n, balance.field);
    require(!is_own || !term.is_explicit, term.where,
            "{}: explicit = true, and a {} balances its terms at every instant; expected {}, or explicit = false", name,
            balance.name, balance.remedy);
    require(!is_own || !balance.has_own(summary.reads), term.where,
            "{}: a term of the balance that depends on its field needs {}; a {} balances the others with {} only", name,
            balance.remedy, balance.name, key_of_term(balance.field.symbol, balance.field.symbol));
    require(!balance.is_pointwise || !balance.has_own(summary.derives), term.where,
            "{}: derivatives of a {} are not available when it depends on the fields at each point; set {}", name,
            balance.name, balance.remedy);
}

/// Derivatives of the field are solved for by wave, products at each point.
void check_products(const Balance& balance, const Locate& locate) {
    const CompiledTerms& e = balance.terms;
    std::string derivative;
    for (std::size_t n = 0; n < e.names.size(); ++n)
        if (e.is_of(n, balance.field) && balance.has_own(e.right_sides.terms()[n].derives)) derivative = e.names[n];
    if (derivative.empty()) return;
    for (std::size_t n = 0; n < e.names.size(); ++n) {
        if (!e.is_of(n, balance.field)) continue;
        const TextTerm* written = text_of(e, n);
        const bool is_linear = e.right_sides.terms()[n].is_linear && !e.right_sides.terms()[n].is_placed;
        if (is_linear && (written == nullptr || e.right_sides.is_isotropic(n))) continue;
        const auto found = e.model.coefficients.find(e.names[n]);
        const bool varies = found != e.model.coefficients.end() && found->second.varies();
        fail_input(written != nullptr ? written->where : locate(e.names[n] + (varies ? "_terms" : "")),
                   "{}: a {} has either terms that are not linear or not isotropic, or derivatives in its balance, of "
                   "{}; set {} to 0, or set {}",
                   written != nullptr ? e.right_sides.terms()[n].text : e.names[n], balance.name, derivative,
                   derivative, balance.remedy);
    }
}

void check_balances(const CompiledTerms& terms, const Locate& locate) {
    const ModelValues& model = terms.model.model;
    const FieldRow* pointwise = pointwise_balance(terms);
    for (const FieldRow& field : model.file->fields) {
        if (presence(model, field) != Presence::balance) continue;
        const std::string name = "slaved " + words_of(field);
        const Balance balance{.terms = terms,
                              .field = field,
                              .name = name,
                              .remedy = field.present + " = \"dynamic\"",
                              .is_pointwise = pointwise == &field};
        const std::string own = key_of_term(field.symbol, field.symbol);
        const double drag = terms.model.coefficient(own).at(mean_densities(model));
        require(drag > 0.0, locate(own),
                "{} is {} in the uniform state; expected > 0: at q = 0 nothing else limits a {}", own, drag, name);
        for (std::size_t n = 0; n < terms.names.size(); ++n)
            if (const TextTerm* written = text_of(terms, n)) check_text(balance, *written, n);
        check_products(balance, locate);
    }
}
}  // namespace

const FieldRow* pointwise_balance(const CompiledTerms& terms) {
    const std::vector<model::TermSummary>& found = terms.right_sides.terms();
    for (const FieldRow& field : terms.model.model.file->fields) {
        if (presence(terms.model.model, field) != Presence::balance) continue;
        for (std::size_t n = 0; n < found.size(); ++n)
            if (terms.is_of(n, field) && (!found[n].is_linear || found[n].is_placed ||
                                          (text_of(terms, n) != nullptr && !terms.right_sides.is_isotropic(n))))
                return &field;
    }
    return nullptr;
}

void check_terms(const CompiledTerms& terms, const Locate& locate) {
    for (std::size_t n = 0; n < terms.names.size(); ++n)
        if (const TextTerm* written = text_of(terms, n)) check_conserved(terms, *written, n);
    check_balances(terms, locate);
}

void check(const ModelValues& model, const Locate& locate) {
    check_numbers(model, locate);
    const CompiledModel compiled(model);
    check_functions(compiled);
    const WrittenModel written = write_model(compiled, Written::right_sides);
    const model::Equations right_sides(written.model);
    check_terms({.model = compiled, .right_sides = right_sides, .names = written.terms}, locate);
    static_cast<void>(model::Equations(write_model(compiled, Written::solver).model));
}

}  // namespace drover::physics
