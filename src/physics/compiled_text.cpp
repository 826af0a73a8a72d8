// physics/compiled_text.cpp: texts of terms as symbolic expressions: their linear parts, their actions, their costs.
#include "compiled_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "compiled_function.hpp"
#include "linear_part.hpp"
#include "term_inputs.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

std::set<int> field_slots() {
    std::set<int> slots;
    for (int slot = 0; slot < position_begin; ++slot) slots.insert(slot);
    return slots;
}

Expression sum_of(const std::vector<Expression>& parts) {
    Expression sum(0.0);
    for (const Expression& part : parts) sum = sum + part;
    return sum;
}

/// The texts of one term with the numbers of its parameters, and where they go.
struct Compiled {
    std::string name, equation;
    Equation of = Equation::polar_order;
    int row = p_x;  ///< of a Symbol: the first of the equation
    int output = Output::order;
    bool is_flux = false;
    std::vector<Expression> components;
};

struct Slope {
    std::size_t component;
    int slot;
    Expression derivative;
};

std::vector<Slope> slopes_of(const Compiled& term) {
    std::vector<Slope> slopes;
    for (std::size_t c = 0; c < term.components.size(); ++c)
        for (const int slot : slots_of(term.components[c])) {
            if (slot >= position_begin) continue;
            Expression slope = derivative(term.components[c], slot);
            if (!is_zero(slope)) slopes.push_back({c, slot, std::move(slope)});
        }
    return slopes;
}

/// A slope in a uniform state.  Where its formula is 0/0, as that of |p| p at p = 0, it is the limit from several
/// sides; NaN where there is none, as of p/|p|.
double slope_at(const Expression& slope, const std::array<double, Input::count>& values) {
    const double here = evaluate(slope, values);
    if (std::isfinite(here)) return here;
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    // Beside the constants of a scene any power of these is nothing, or far too large.
    constexpr double rounding = 1e-15;
    double limit = none;
    for (const double size : {1e-60, 1e-40})
        for (int side = 0; side < 5; ++side) {
            std::array<double, Input::count> near = values;
            for (std::size_t slot = 0; slot < position_begin; ++slot)
                if (near[slot] == 0.0) near[slot] = size * std::cos(1.3 * side + 2.4 * static_cast<double>(slot));
            const double found = evaluate(slope, near);
            if (std::isnan(limit)) limit = found;
            if (!(std::abs(found - limit) <= rounding * (1.0 + std::abs(limit)))) return none;
        }
    return std::abs(limit) <= rounding ? 0.0 : limit;
}

/// Whether a term has a linearisation about a state at rest.
bool has_slopes(const Compiled& term, const UniformPoint& rest) {
    const std::vector<Slope> slopes = slopes_of(term);
    return std::all_of(slopes.begin(), slopes.end(), [values = slots_at(rest)](const Slope& slope) {
        return std::isfinite(slope_at(slope.derivative, values));
    });
}

/// Whether the components vanish in every uniform state.
bool vanishes_when_uniform(const Compiled& term) {
    return std::all_of(term.components.begin(), term.components.end(), [](Expression uniform) {
        for (int slot = derivatives_begin; slot < position_begin; ++slot) uniform = bind(uniform, slot, 0.0);
        return is_zero(uniform);
    });
}

bool depends_on(const Compiled& term, int from, int to) {
    for (const Expression& component : term.components)
        for (const int slot : slots_of(component))
            if (slot >= from && slot < to) return true;
    return false;
}

bool reads_any_velocity(const Compiled& term) {
    for (const Expression& component : term.components)
        for (const int slot : slots_of(component))
            if (is_of_velocity(slot)) return true;
    return false;
}

Term base_term(const Compiled& compiled) {
    Term term{.name = compiled.name, .of = compiled.of};
    term.equation = [equation = compiled.equation](const CompiledModel&) { return equation; };
    term.linearise = [compiled, slopes = slopes_of(compiled)](const CompiledModel&, const UniformPoint& about,
                                                              const Wavevector& q, Symbol& m) {
        const auto values = slots_at(about);
        for (const Slope& slope : slopes)
            add_derivative(compiled.row, compiled.is_flux, slope.component, slope_at(slope.derivative, values),
                           slope.slot, q, m);
    };
    term.degree_in_q = compiled.is_flux && depends_on(compiled, Input::laplacian, position_begin) ? 4 : 2;
    term.closed_uniform_states = vanishes_when_uniform(compiled);
    return term;
}

PointCost cost_of(const Compiled& compiled) {
    PointCost cost{.writes = writes(compiled.output)};
    int highest = 1;
    for (const Expression& component : compiled.components) {
        for (const int slot : slots_of(component)) cost.reads |= reads(slot);
        const std::optional<int> found = degree(component, field_slots());
        // Like 1/rho it counts as a product of two: outputs report the tail of the spectrum.
        highest = std::max(highest, found.value_or(2));
        cost.has_finite_degree = cost.has_finite_degree && found.has_value();
        if (depends_on(compiled, position_begin, Input::t)) cost.has_finite_degree = false;
    }
    cost.degree = highest;
    for (const std::uint64_t pair : {reads_velocity, reads_order})
        if (cost.reads & pair) cost.reads |= pair;
    return cost;
}

/// The part that is evaluated at points.
Term pointwise_term(const Compiled& compiled, LinearPart part) {
    Term term = base_term(compiled);
    term.linear_part = part;
    term.is_uniform_in_space = !depends_on(compiled, position_begin, Input::count);
    term.cost = [cost = cost_of(compiled)](const CompiledModel&, bool) { return cost; };
    term.whole = [program = std::make_shared<const StripProgram>(compiled.components), output = compiled.output,
                  count = compiled.components.size()](const CompiledModel&, const Reference&, const PointFields& f,
                                                      const PointRates& r) {
        std::array<double, Input::count> uniform{};
        uniform[Input::t] = f.time;
        std::array<double*, 2> out{};
        for (std::size_t c = 0; c < count; ++c) out[c] = r[output + static_cast<int>(c)];
        program->add(f.size, f.values, uniform, std::span(out.data(), count));
    };
    return term;
}

/// Splits the components into summands that are linear with constant coefficients, and the others.
std::pair<Compiled, Compiled> split(const Compiled& term) {
    static const std::set<int> fields = field_slots();
    Compiled linear = term, rest = term;
    linear.name += " (linear)";
    for (std::size_t c = 0; c < term.components.size(); ++c) {
        std::vector<Expression> straight, others;
        for (const Expression& part : summands(term.components[c])) {
            const std::set<int> slots = slots_of(part);
            const bool at_a_place = !slots.empty() && *slots.rbegin() >= position_begin;
            (degree(part, fields) == 1 && !at_a_place ? straight : others).push_back(part);
        }
        linear.components[c] = sum_of(straight);
        rest.components[c] = sum_of(others);
    }
    return {linear, rest};
}

bool is_empty(const Compiled& term) {
    return std::all_of(term.components.begin(), term.components.end(), [](const Expression& e) { return is_zero(e); });
}

/// Reads the texts of one term.
Compiled read_term(const CompiledModel& model, const TextTerm& written, std::size_t number) {
    const Target& target = target_of(model, written);
    const bool is_scalar = target.flux >= 0, is_flux = !written.flux.empty();
    require(is_flux != !written.value.empty(), written.where, "expected either value or flux in a term, {}",
            is_flux ? "found both" : "found neither");
    require(!is_flux || is_scalar, written.where, "only a density has a flux; of = \"{}\" needs a value", written.of);
    const std::vector<WrittenExpression>& texts = is_flux ? written.flux : written.value;
    const std::size_t expected = is_scalar && !is_flux ? 1 : 2;
    require(texts.size() == expected, written.where, "{} has {} expressions; expected {}", is_flux ? "flux" : "value",
            texts.size(), expected == 1 ? "one, for a density" : "two, the x and y components");
    Compiled result{.name = text("terms[{}]", number),
                    .equation = {},
                    .of = target.which,
                    .row = target.row,
                    .output = is_flux ? target.flux : target.rate,
                    .is_flux = is_flux,
                    .components = {}};
    const Vocabulary names = vocabulary_of(model);
    std::vector<std::string> shown;
    for (const WrittenExpression& one : texts) {
        Expression expression = parse_expression(one.text, names, one.where);
        int slot = parameters_begin;
        for (const auto& [name, value] : model.model.parameters) expression = bind(expression, slot++, value);
        result.components.push_back(std::move(expression));
        shown.push_back(one.text);
    }
    result.equation = text(is_flux            ? "{}: -div({})"
                           : shown.size() > 1 ? "{}: ({})"
                                              : "{}: {}",
                           target.equation, joined(shown));
    for (const std::string& name : written.parameters)
        result.equation += text(", {} = {}", name, model.model.parameters.at(name));
    return result;
}

bool derives_any_velocity(const Compiled& term) {
    for (const Expression& component : term.components)
        for (const int slot : slots_of(component))
            if (slot >= Input::d_x && is_of_velocity(slot)) return true;
    return false;
}
}  // namespace

std::vector<Term> compiled_text_terms(const CompiledModel& model, bool pointwise_velocity) {
    std::vector<Term> terms;
    for (std::size_t n = 0; n < model.model.text_terms.size(); ++n) {
        const TextTerm& written = model.model.text_terms[n];
        if (!written.function.empty()) {
            terms.push_back(compiled_function(model, written, n + 1, pointwise_velocity));
            continue;
        }
        const Compiled whole = read_term(model, written, n + 1);
        auto [linear, rest] = split(whole);
        const bool slaved_force = model.form.velocity == Velocity::slaved && whole.of == Equation::bead_velocity;
        Term exact = base_term(linear);
        // What reads a velocity that is no linear function of the fields is evaluated at points.
        if (!has_isotropic_linearisation(model, exact) || (pointwise_velocity && reads_any_velocity(linear))) {
            rest = whole;
            linear.components.assign(linear.components.size(), Expression(0.0));
        }
        check_admissible(model, written.where,
                         {.name = whole.name,
                          .of = whole.of,
                          .conserves = whole.is_flux || vanishes_when_uniform(whole),
                          .reads_velocity = reads_any_velocity(whole),
                          .derives_velocity = derives_any_velocity(whole),
                          .is_linear = is_empty(rest)},
                         pointwise_velocity);
        if (!is_empty(rest)) {
            if (is_empty(linear)) rest.name = whole.name;
            const bool placed = depends_on(rest, position_begin, Input::count);
            const bool has_linear_part = placed || has_slopes(rest, at_rest(reference(model.model.uniform)));
            if (!has_linear_part) rest.equation += ", explicit: it has no derivative where its fields are at rest";
            const bool is_explicit = placed || slaved_force || !has_linear_part;
            terms.push_back(pointwise_term(rest, is_explicit ? LinearPart::none : LinearPart::averaged));
        }
        if (is_empty(linear)) continue;
        if (is_empty(rest)) exact.name = whole.name;
        terms.push_back(std::move(exact));
    }
    return terms;
}

}  // namespace drover::physics
