// model/summands.cpp: from the text of an equation to its summands, and what of them is white noise.
#include "model/summands.hpp"

#include <algorithm>

namespace drover::model {

Model with_noises_as_fields(const Model& model) {
    Model result = model;
    for (const WhiteNoise& noise : model.noises)
        result.fields.push_back({.name = noise.symbol,
                                 .symbol = noise.symbol,
                                 .spin = noise.spin,
                                 .odd = noise.odd,
                                 .left = LeftSide::given,
                                 .where = noise.where});
    return result;
}

Model driven_model(const Model& model, std::size_t driven, const std::set<std::size_t>& noises) {
    Model result = model;
    result.noises.clear();
    for (std::size_t i = 0; i < model.fields.size(); ++i) {
        Field& field = result.fields[i];
        field.noise = 0.0;
        if (field.left != LeftSide::rate || i == driven) continue;
        field.equation = field.mass = {};
        field.further.clear();
    }
    const std::vector<Field> given = with_noises_as_fields(model).fields;
    for (const std::size_t n : noises) result.fields.push_back(given[model.fields.size() + n]);
    return result;
}

SummandReader::SummandReader(const Model& with_noises, Lowering& lowering, Algebra& algebra)
    : model_(with_noises), lowering_(lowering), algebra_(algebra) {
    const std::size_t fields = model_.fields.size() - model_.noises.size();
    for (std::size_t i = 0; i < fields; ++i) components_ += components(model_.fields[i]);
    for (std::size_t n = 0; n < model_.noises.size(); ++n)
        noise_of_.insert(noise_of_.end(), static_cast<std::size_t>(components(model_.noises[n])), n);
}

std::vector<Summand> SummandReader::read(std::size_t index, const std::optional<Formula>& mass,
                                         const std::function<bool(std::size_t number)>& takes) {
    const Field& field = model_.fields[index];
    std::vector<Summand> summands;
    std::size_t number = 0;
    const auto add = [&](Summand one) {
        if (field.part != Part::whole && algebra_.is_zero(one.value.components[0])) return;
        one.number = number;
        find_noise(one);
        summands.push_back(std::move(one));
    };
    if (!field.equation.text.empty()) {
        const FormulaText text(field.equation.text, field.equation.where);
        const Formula whole = parse_formula(text, notation_with(model_.functions));
        const bool is_in_parentheses = whole.at != text.text().find_first_not_of(" \t\n");
        if (whole.kind != Formula::Kind::sum || is_in_parentheses) {
            if (takes(number)) add(summand(index, text, whole, 0, text.text().size(), mass));
            ++number;
        } else
            for (std::size_t i = 0; i < whole.arguments.size(); ++i, ++number)
                if (takes(number))
                    add(summand(index, text, whole.arguments[i], i == 0 ? 0 : whole.arguments[i].sign_at,
                                i + 1 < whole.arguments.size() ? whole.arguments[i + 1].sign_at : text.text().size(),
                                mass));
    }
    for (std::size_t i = 0; i < field.further.size(); ++i, ++number)
        if (takes(number)) add(written(index, field.further[i]));
    return summands;
}

namespace {
bool equal(const Formula& a, const Formula& b) {
    const auto equal_parts = [](const Formula& c, const Formula& d) { return c.sign == d.sign && equal(c, d); };
    return a.kind == b.kind && a.name == b.name && a.value == b.value && a.arguments.size() == b.arguments.size() &&
           std::equal(a.arguments.begin(), a.arguments.end(), b.arguments.begin(), equal_parts);
}

/// Whether a summand is "explicit(...)" or "-explicit(...)", which is then what it contains.
bool remove_explicit(Formula& formula) {
    Formula* inner = &formula;
    while (inner->kind == Formula::Kind::negative) inner = &inner->arguments[0];
    if (inner->kind != Formula::Kind::call || inner->name != explicit_name) return false;
    const char sign = inner->sign;
    *inner = Formula(inner->arguments[0]);
    inner->sign = sign;
    return true;
}

/// Takes the factors of the mass away from the front of a product, if they are there.
bool remove_mass(Formula& formula, const Formula& mass) {
    if (formula.kind != Formula::Kind::product) return false;
    const std::vector<Formula> factors =
        mass.kind == Formula::Kind::product ? mass.arguments : std::vector<Formula>{mass};
    std::vector<Formula>& found = formula.arguments;
    if (found.size() <= factors.size() || found[factors.size()].sign == '/') return false;
    const bool is_negative = found[0].kind == Formula::Kind::negative;
    for (std::size_t i = 0; i < factors.size(); ++i) {
        const Formula& factor = i == 0 && is_negative ? found[0].arguments[0] : found[i];
        if (factors[i].sign == '/' || found[i].sign == '/' || !equal(factor, factors[i])) return false;
    }
    found.erase(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(factors.size()));
    if (is_negative) {
        Formula first = std::move(found[0]);
        found[0] = {.kind = Formula::Kind::negative, .arguments = {first}, .at = first.at, .sign = '*'};
    }
    return true;
}
}  // namespace

Summand SummandReader::written(std::size_t index, const WrittenTerm& term) {
    const Field& field = model_.fields[index];
    Summand result;
    result.summary = {.field = index,
                      .text = term.name,
                      .where = term.texts.at(0).where,
                      .is_explicit = term.is_explicit};
    result.value = lowering_.value_of(term);
    const FormulaText text(term.texts[0].text, term.texts[0].where);
    lowering_.check(text, {}, result.value, {0, field.spin}, field.odd ? Parity::odd : Parity::even);
    result.value.components.resize(static_cast<std::size_t>(components(field)));  // of 0
    return result;
}

Summand SummandReader::summand(std::size_t index, const FormulaText& text, Formula formula, std::size_t begin,
                               std::size_t end, const std::optional<Formula>& mass) {
    const Field& field = model_.fields[index];
    Summand result;
    result.summary.field = index;
    result.summary.text = text.text().substr(begin, end - begin);
    result.summary.text.erase(result.summary.text.find_last_not_of(" \n\t") + 1);
    result.summary.where = text.location(begin);
    result.summary.is_explicit = remove_explicit(formula);
    require(!result.summary.is_explicit || field.left == LeftSide::rate, result.summary.where,
            "the term \"{}\" is explicit, and {} is in balance: it is solved at every instant; expected the term "
            "without explicit(...)",
            result.summary.text, field.symbol);
    if (mass) result.is_acceleration = remove_mass(formula, *mass);
    result.value = lowering_.value_of(text, formula);
    if (field.part == Part::imaginary) {
        result.value.imaginary.resize(result.value.components.size());
        result.value.components = result.value.imaginary;
    }
    if (field.part != Part::whole) result.value.imaginary.clear();
    lowering_.check(text, formula, result.value, {0, field.spin}, field.odd ? Parity::odd : Parity::even);
    result.value.components.resize(static_cast<std::size_t>(components(field)));  // of 0
    if (formula.sign == '-')
        for (Component& c : result.value.components) c = algebra_.scaled(c, -1.0);
    return result;
}

// ---- white noise

bool SummandReader::reads_noise(int node) const {
    return std::ranges::any_of(algebra_.slots_read(node), [&](int slot) { return has_noise(algebra_.form_of(slot)); });
}

/// Finds the white noises of a summand; where they have constant coefficients they leave its value.
void SummandReader::find_noise(Summand& summand) const {
    if (noise_of_.empty()) return;
    const auto add = [&](const LinearForm& form) {
        for (const auto& [derivative, coefficient] : form)
            if (is_noise(derivative))
                summand.noises.insert(noise_of_[static_cast<std::size_t>(derivative.component - components_)]);
    };
    for (const Component& rate : summand.value.components) {
        add(rate.linear);
        for (const auto& [order, node] : rate.rest) {
            summand.multiplies_noise = summand.multiplies_noise || reads_noise(node);
            for (const int slot : algebra_.slots_read(node)) add(algebra_.form_of(slot));
        }
    }
    const Field& field = model_.fields[summand.summary.field];
    require(field.left == LeftSide::rate || !summand.has_noise(), summand.summary.where,
            "the term \"{}\" is noise, and {} is in balance; expected noise of fields with a rate",
            summand.summary.text, field.symbol);
    if (summand.multiplies_noise) return check_product(summand);
    for (Component& rate : summand.value.components) {
        LinearForm noise;
        for (const auto& entry : rate.linear)
            if (is_noise(entry.first)) noise.insert(entry);
        std::erase_if(rate.linear, [this](const auto& entry) { return is_noise(entry.first); });
        summand.noise.push_back(std::move(noise));
    }
}

/// The noise of a product is one of its factors, once.
void SummandReader::check_product(const Summand& summand) const {
    const auto check = [&](bool holds, const char* what, const char* expected) {
        require(holds, summand.summary.where, "the term \"{}\" {}; expected {}", summand.summary.text, what, expected);
    };
    constexpr const char *once = "noise as a factor, once", *apart = "noise as a summand of its own",
                         *not_linear = "is not proportional to its noise";
    const auto without_noise = [&](Expression value, int slot) {
        try {
            return bind(value, slot, 0.0);
        } catch (const Error&) {  // such as a quotient by the noise
            check(false, not_linear, once);
            throw;
        }
    };
    for (const Component& rate : summand.value.components) {
        for (const auto& [derivative, coefficient] : rate.linear)
            check(is_noise(derivative), "adds noise to a term without noise", apart);
        for (const auto& [order, node] : rate.rest) {
            const Expression value = algebra_.graph.expression(node);
            Expression without = value;
            std::set<int> slots;
            for (const int slot : slots_of(value)) {
                const LinearForm& form = algebra_.form_of(slot);
                if (!has_noise(form)) continue;
                const bool all = std::ranges::all_of(form, [this](const auto& e) { return is_noise(e.first); });
                check(all, "adds noise to fields in a factor", once);
                slots.insert(slot);
                without = without_noise(without, slot);
            }
            check(drover::is_zero(without), "mixes noise with terms without noise", apart);
            for (const int slot : slots)
                for (const int other : slots_of(derivative(value, slot, summand.summary.where)))
                    check(!slots.contains(other), not_linear, once);
        }
    }
}

void SummandReader::check_mass(const Field& field, const Value& mass) const {
    for (const Component& part : mass.components) {
        bool any = has_noise(part.linear);
        for (const auto& [order, node] : part.rest) any = any || reads_noise(node);
        require(!any, field.mass.where, "the mass of {} has noise; expected a function of the fields", field.symbol);
    }
}

}  // namespace drover::model
