// physics/compiled_text.cpp: texts of terms as symbolic expressions: their linear parts, their actions, their costs.
#include "compiled_text.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <set>

#include "drover/base/expression.hpp"
#include "linear_part.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

constexpr int derivatives_begin = Input::d_x, position_begin = Input::x, parameters_begin = Input::count;

struct FieldName {
    const char* name;
    int field;
};
constexpr std::array field_names{FieldName{"bead_density", rho},    FieldName{"rod_density", sigma},
                                 FieldName{"bead_velocity_x", v_x}, FieldName{"bead_velocity_y", v_y},
                                 FieldName{"order_x", p_x},         FieldName{"order_y", p_y}};

bool has_field(const Form& form, int field) {
    if (field == rho) return form.bead_density >= 0;
    if (field == sigma) return form.rod_density >= 0;
    return field >= p_x || form.velocity != Velocity::absent;
}

/// The names that a text may use in this form.
Vocabulary vocabulary_of(const CompiledModel& model) {
    Vocabulary names;
    const auto add_vector = [&](const char* name, int divergence, int curl, int grad_div) {
        names.operators["div"][name] = divergence;
        names.operators["curl"][name] = curl;
        names.operators["grad_div_x"][name] = grad_div;
        names.operators["grad_div_y"][name] = grad_div + 1;
    };
    for (const auto& [name, field] : field_names) {
        if (!has_field(model.form, field)) continue;
        names.variables[name] = field;
        names.operators["d_x"][name] = Input::d_x + field;
        names.operators["d_y"][name] = Input::d_y + field;
        names.operators["lap"][name] = Input::laplacian + field;
    }
    add_vector("order", Input::order_divergence, Input::order_curl, Input::order_grad_div);
    if (has_field(model.form, v_x))
        add_vector("bead_velocity", Input::velocity_divergence, Input::velocity_curl, Input::velocity_grad_div);
    names.variables["x"] = Input::x;
    names.variables["y"] = Input::y;
    names.variables["t"] = Input::t;
    int slot = parameters_begin;
    for (const auto& [name, value] : model.model.parameters) names.variables[name] = slot++;
    return names;
}

/// What a slot is of the fields at q: at most two of them, times factors.
struct SlotSymbol {
    std::array<int, 2> field{};
    std::array<std::complex<double>, 2> factor{};
};
SlotSymbol symbol_of_slot(int slot, const Wavevector& q) {
    const std::complex<double> d_x = i_unit * q.x, d_y = i_unit * q.y;
    if (slot == Input::velocity_curl) return {{v_y, v_x}, {d_x, -d_y}};
    if (slot == Input::order_curl) return {{p_y, p_x}, {d_x, -d_y}};
    if (slot == Input::velocity_divergence) return {{v_x, v_y}, {d_x, d_y}};
    if (slot == Input::order_divergence) return {{p_x, p_y}, {d_x, d_y}};
    if (slot >= Input::velocity_grad_div) {
        const bool of_order = slot >= Input::order_grad_div, along_y = (slot - Input::velocity_grad_div) % 2 == 1;
        const double q_out = along_y ? q.y : q.x;
        return {{of_order ? p_x : v_x, of_order ? p_y : v_y}, {-q_out * q.x, -q_out * q.y}};
    }
    const int field = slot % FieldIndex::count;
    if (slot >= Input::laplacian) return {{field, field}, {-(q.x * q.x + q.y * q.y), 0.0}};
    if (slot >= Input::d_y) return {{field, field}, {d_y, 0.0}};
    if (slot >= Input::d_x) return {{field, field}, {d_x, 0.0}};
    return {{field, field}, {1.0, 0.0}};
}

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

/// The rates that a derivative of a component contributes to: a row, times a factor.
void add_derivative(const Compiled& term, std::size_t component, double slope, int slot, const Wavevector& q,
                    Symbol& m) {
    const SlotSymbol symbol = symbol_of_slot(slot, q);
    const std::complex<double> outer =
        term.is_flux ? -i_unit * (component == 0 ? q.x : q.y) : std::complex<double>(1.0);
    const int row = term.is_flux ? term.row : term.row + static_cast<int>(component);
    for (std::size_t k = 0; k < 2; ++k)
        if (symbol.factor[k] != 0.0) m(row, symbol.field[k]) += outer * slope * symbol.factor[k];
}

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

std::array<double, Input::count> slots_at(const UniformPoint& about) {
    std::array<double, Input::count> values{};
    values[Input::bead_density] = about.bead_density;
    values[Input::rod_density] = about.rod_density;
    for (int i = 0; i < 2; ++i) {
        values[static_cast<std::size_t>(Input::bead_velocity_x + i)] = about.velocity(i);
        values[static_cast<std::size_t>(Input::polar_order_x + i)] = about.order(i);
    }
    return values;
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
            add_derivative(compiled, slope.component, evaluate(slope.derivative, values), slope.slot, q, m);
    };
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
    struct Target {
        const char* of;
        const char* equation;
        Equation which;
        int row, rate, flux;  ///< flux: -1 of a vector
    };
    static constexpr std::array targets{
        Target{"bead_density", "d_t rho", Equation::bead_density, rho, Output::bead_rate, Output::bead_flux},
        Target{"rod_density", "d_t sigma", Equation::rod_density, sigma, Output::rod_rate, Output::rod_flux},
        Target{"bead_velocity", "m rho d_t v", Equation::bead_velocity, v_x, Output::force, -1},
        Target{"order", "d_t p", Equation::polar_order, p_x, Output::order, -1}};
    const auto* target =
        std::find_if(targets.begin(), targets.end(), [&](const Target& t) { return written.of == t.of; });
    require(target != targets.end(), written.where,
            "of = \"{}\"; expected one of bead_density, rod_density, bead_velocity, order: the field of the equation",
            written.of);
    require(has_field(model.form, target->row), written.where,
            "of = \"{}\", a field that this model excludes; include the field in [fields], or remove the term",
            written.of);
    const bool is_scalar = target->flux >= 0, is_flux = !written.flux.empty();
    require(is_flux != !written.value.empty(), written.where, "expected either value or flux in a term, {}",
            is_flux ? "found both" : "found neither");
    require(!is_flux || is_scalar, written.where, "only a density has a flux; of = \"{}\" needs a value", written.of);
    const std::vector<WrittenExpression>& texts = is_flux ? written.flux : written.value;
    const std::size_t expected = is_scalar && !is_flux ? 1 : 2;
    require(texts.size() == expected, written.where, "{} has {} expressions; expected {}", is_flux ? "flux" : "value",
            texts.size(), expected == 1 ? "one, for a density" : "two, the x and y components");
    Compiled result{.name = text("terms[{}]", number),
                    .equation = {},
                    .of = target->which,
                    .row = target->row,
                    .output = is_flux ? target->flux : target->rate,
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
                           target->equation, joined(shown));
    for (const std::string& name : written.parameters)
        result.equation += text(", {} = {}", name, model.model.parameters.at(name));
    return result;
}

void check_admissible(const CompiledModel& model, const TextTerm& written, const Compiled& whole, const Compiled& rest,
                      bool pointwise_velocity) {
    const bool density = whole.of == Equation::bead_density || whole.of == Equation::rod_density;
    require(!density || whole.is_flux || vanishes_when_uniform(whole), written.where,
            "{} changes the number of {} in a uniform state, which the equations conserve; use a flux", whole.name,
            whole.of == Equation::bead_density ? "beads" : "rods");
    if (model.form.velocity != Velocity::slaved) return;
    require(whole.of != Equation::bead_velocity || !reads_any_velocity(whole), written.where,
            "{}: a force that depends on the bead velocity needs fields.bead_velocity = \"dynamic\"; a slaved velocity "
            "balances forces with drag.coefficient only",
            whole.name);
    const bool viscous = model.model.viscosity.shear != 0.0 || model.model.viscosity.bulk != 0.0;
    require(!viscous || whole.of != Equation::bead_velocity || is_empty(rest), written.where,
            "{}: a slaved velocity with viscosity allows only linear isotropic forces; set viscosity.shear and "
            "viscosity.bulk to 0, or set fields.bead_velocity = \"dynamic\"",
            whole.name);
    bool derives_velocity = false;
    for (const Expression& component : whole.components)
        for (const int slot : slots_of(component))
            derives_velocity = derives_velocity || (slot >= Input::d_x && is_of_velocity(slot));
    require(!derives_velocity || !pointwise_velocity, written.where,
            "{}: derivatives of a slaved velocity are not available when it depends on the densities at each point; "
            "set fields.bead_velocity = \"dynamic\"",
            whole.name);
}
}  // namespace

std::vector<Term> compiled_text_terms(const CompiledModel& model, bool pointwise_velocity) {
    std::vector<Term> terms;
    for (std::size_t n = 0; n < model.model.text_terms.size(); ++n) {
        const TextTerm& written = model.model.text_terms[n];
        const Compiled whole = read_term(model, written, n + 1);
        auto [linear, rest] = split(whole);
        const bool slaved_force = model.form.velocity == Velocity::slaved && whole.of == Equation::bead_velocity;
        Term exact = base_term(linear);
        // What reads a velocity that is no linear function of the fields is evaluated at points.
        if (!has_isotropic_linearisation(model, exact) || (pointwise_velocity && reads_any_velocity(linear))) {
            rest = whole;
            linear.components.assign(linear.components.size(), Expression(0.0));
        }
        check_admissible(model, written, whole, rest, pointwise_velocity);
        if (!is_empty(rest)) {
            if (is_empty(linear)) rest.name = whole.name;
            const bool placed = depends_on(rest, position_begin, Input::count);
            terms.push_back(pointwise_term(rest, placed || slaved_force ? LinearPart::none : LinearPart::averaged));
        }
        if (is_empty(linear)) continue;
        if (is_empty(rest)) exact.name = whole.name;
        terms.push_back(std::move(exact));
    }
    return terms;
}

}  // namespace drover::physics
