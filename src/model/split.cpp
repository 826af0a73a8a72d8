// model/split.cpp: the exact linear part about a uniform state, and the functions that it leaves to the explicit part.
#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "model/compiled.hpp"

namespace drover::model {

// ---- expressions with calls

std::set<int> CompiledEquations::slots_read(const Expression& expression) const {
    std::set<int> result;
    for (const int slot : slots_of(expression)) {
        const Call* call = call_at(slot);
        if (call == nullptr) result.insert(slot);
        else
            for (const Expression& argument : call->values) result.merge(slots_read(argument));
    }
    return result;
}

Expression CompiledEquations::slope(const Expression& expression, int slot, const SourceLocation& where) const {
    if (calls.empty()) return derivative(expression, slot, where);
    GraphBuilder graph(Folding::simplified, where);
    std::vector<FunctionCall> here(calls.begin(), calls.end());
    for (std::size_t n = 0; n < calls.size(); ++n)
        for (std::size_t a = 0; a < calls[n].values.size(); ++a)
            here[n].arguments[a] = graph.import(calls[n].values[a].graph());
    const int root = graph.import(expression.graph());
    return graph.expression(
        total_slope(graph, here, root, [&](int other) { return graph.number(other == slot ? 1.0 : 0.0); }));
}

double CompiledEquations::limit_at(const Expression& slope, const std::vector<double>& values) const {
    const double here = evaluate(slope, values);
    if (std::isfinite(here)) return here;
    std::vector<std::size_t> zeros;
    for (const int slot : slots_of(slope)) {
        if (call_at(slot) != nullptr) return nan;  // its value depends on others
        const auto place = static_cast<std::size_t>(slot);
        if (slot >= first_atom && values[place] == 0.0) zeros.push_back(place);
    }
    // Beside the constants of a scene any power of these sizes is nothing, or far too large.
    constexpr double rounding = 1e-15;
    double limit = nan;
    for (const double size : {1e-60, 1e-40})
        for (int side = 0; side < 5; ++side) {
            std::vector<double> near = values;
            for (const std::size_t place : zeros) near[place] = size * std::cos(1.3 * side + 2.4 * double(place));
            const double found = evaluate(slope, near);
            if (std::isnan(limit)) limit = found;
            if (!(std::abs(found - limit) <= rounding * (1.0 + std::abs(limit)))) return nan;
        }
    return std::abs(limit) <= rounding ? 0.0 : limit;
}

double CompiledEquations::slope_at(const Expression& slope, const std::vector<double>& values) const {
    return jumps_at(slope, values) ? nan : limit_at(slope, values);
}

bool CompiledEquations::is_continuous_at(const PointFunction& function, const std::vector<double>& values) const {
    if (jumps_at(function.value, values)) return false;
    return function.slopes.empty() || std::isfinite(limit_at(function.value, values));
}

bool CompiledEquations::has_slopes(const Term& term, const std::vector<double>& values) const {
    for (const Row& row : term.rows)
        for (const PointFunction& function : row.functions) {
            if (!is_continuous_at(function, values)) return false;
            for (const PointFunction::Slope& slope : function.slopes)
                if (!std::isfinite(slope_at(slope.value, values))) return false;
        }
    return true;
}

PointDegree CompiledEquations::degree_of(const Expression& expression) const {
    return point_degree(expression, [this](int slot) -> std::optional<PointDegree> {
        const Call* call = call_at(slot);
        if (call == nullptr) return {};
        PointDegree result{0, call->function->has_finite_degree};
        for (const Expression& argument : call->values) {
            const PointDegree found = degree_of(argument);
            result.degree = std::max(result.degree, found.degree);
            result.is_finite = result.is_finite && found.is_finite;
        }
        result.degree *= call->function->degree;
        return result;
    });
}

void CompiledEquations::call(const Call& call, bool with_slopes, std::vector<double>& values) const {
    std::vector<double> arguments;
    std::vector<PointArgument> given;
    for (const Expression& argument : call.values) {
        arguments.push_back(evaluate(argument, values));
        given.push_back({.number = arguments.back()});
    }
    std::array<double*, 2> out{};
    for (int k = 0; k < call.function->results; ++k)
        out[static_cast<std::size_t>(k)] = &values[static_cast<std::size_t>(call.value_slot(k))];
    call.function->values(1, given, std::span(out).first(static_cast<std::size_t>(call.function->results)));
    if (!with_slopes) return;
    const std::vector<double> slopes = slopes_of(*call.function, arguments);
    for (int k = 0; k < call.function->results; ++k)
        for (std::size_t a = 0; a < arguments.size(); ++a)
            values[static_cast<std::size_t>(call.slope_slot(k, static_cast<int>(a)))] =
                slopes[static_cast<std::size_t>(k) * arguments.size() + a];
}

std::vector<double> CompiledEquations::slots_at(const UniformState& at, bool with_slopes) const {
    std::vector<double> values(static_cast<std::size_t>(slots()), 0.0);
    for (std::size_t i = 0; i < atoms.size(); ++i)
        for (const auto& [derivative, coefficient] : atoms[i])
            if (derivative.order == Order{})
                values[first_atom + i] += coefficient * at[static_cast<std::size_t>(derivative.component)];
    for (const Call& one : calls) call(one, with_slopes, values);
    return values;
}

namespace {
/// Whether a function vanishes where all derivatives of fields do.  One that is not defined there does not.
bool vanishes(const CompiledEquations& c, Expression value) try {
    for (const int slot : slots_of(value)) {
        if (slot < first_atom || c.call_at(slot) != nullptr) continue;
        const LinearForm& form = c.form_of(slot);
        if (std::ranges::none_of(form, [](const auto& e) { return e.first.order == Order{}; }))
            value = bind(value, slot, 0.0);
    }
    return is_zero(value);
} catch (const Error& error) {
    if (error.fault() != Fault::input) throw;
    return false;
}

/// Targets of functions at points: (component, order) -> node.
using Remainders = std::map<std::pair<int, Order>, int>;

class Splitting {
public:
    explicit Splitting(CompiledEquations& c) : c_(c), slots_(c.slots_at(c.about)) {}

    void run() {
        check_masses();
        for (const Term& term : c_.evaluated) add(term);
        collect_outputs();
        for (LinearForm& row : c_.linear) std::erase_if(row, [](const auto& entry) { return entry.second == 0.0; });
        c_.is_isotropic = c_.commutes_with_turns(c_.linear);
        check_substitutes();
        check_balances();
        for (const std::vector<RateFunction>* outputs : {&c_.outputs, &c_.forces})
            for (const RateFunction& output : *outputs) {
                const PointDegree found = c_.degree_of(output.value);
                c_.has_finite_degree = c_.has_finite_degree && found.is_finite;
                c_.degree = std::max(c_.degree, found.degree);
            }
        for (const NoiseProducts& one : c_.products) {
            c_.has_finite_degree = c_.has_finite_degree && one.equations->has_finite_degree;
            c_.degree = std::max(c_.degree, one.equations->degree);
        }
    }

private:
    void check_masses() const {
        for (const Mass& mass : c_.masses) {
            const double value = evaluate(c_.calls[mass.call].values[0], slots_);
            require(value > 0.0 && std::isfinite(value), mass.where,
                    "the mass is {} in the state of the references; expected a number above 0", value);
        }
    }

    /// Linear parts about the reference, and the functions without them.
    void add(const Term& term) {
        graph_.where = term.summary.where;
        const int first = c_.first_component[term.summary.field];
        std::vector<LinearForm> slopes(static_cast<std::size_t>(c_.components));
        Remainders whole, rest;
        const bool is_demanded = term.summary.is_explicit, is_whole = is_demanded || is_directed_force(term);
        for (std::size_t k = 0; k < term.rows.size(); ++k) {
            const int component = first + static_cast<int>(k);
            const LinearForm& form = term.rows[k].linear;
            if (!is_whole) add(form, term.summary.where, c_.linear[static_cast<std::size_t>(component)]);
            else if (!form.empty()) add_remainder({component, Order{}}, graph_.slot(slot_of(form)));
            for (const PointFunction& function : term.rows[k].functions) {
                const int node = graph_.import(function.value.graph());
                whole[{component, function.order}] = node;
                rest[{component, function.order}] =
                    without_slopes(function, node, slopes[static_cast<std::size_t>(component)]);
            }
        }
        // What names directions, has no derivative, or is said to, stays in the explicit part as a whole.  Of an
        // equation with terms that are written apart the propagator takes the average over directions: a mass may join
        // them with stiff forces.
        const bool is_apart = !c_.model.fields[term.summary.field].further.empty();
        const bool is_explicit = is_demanded || term.summary.is_placed || !c_.has_slopes(term, slots_) ||
                                 (!is_apart && !c_.commutes_with_turns(slopes));
        for (const auto& [target, node] : is_explicit ? whole : rest) add_remainder(target, node);
        for (std::size_t k = 0; k < slopes.size() && !is_explicit; ++k)
            add(slopes[k], term.summary.where, c_.linear[k]);
    }

    void add_remainder(const std::pair<int, Order>& target, int node) {
        const auto place = remainders_.emplace(target, graph_.number(0.0)).first;
        place->second = graph_.make(Operation::add, place->second, node);
    }

    /// Whether the linear part of a term in a balance names directions, and is one of other fields: a weight "n e_y".
    bool is_directed_force(const Term& term) const {
        const int first = c_.first_component[term.summary.field];
        if (!c_.in_balance(first)) return false;
        std::vector<LinearForm> rows(static_cast<std::size_t>(c_.components));
        for (std::size_t k = 0; k < term.rows.size(); ++k) {
            const LinearForm& form = rows[static_cast<std::size_t>(first) + k] = term.rows[k].linear;
            for (const auto& [derivative, coefficient] : form)
                if (c_.in_balance(derivative.component)) return false;
        }
        return !c_.commutes_with_turns(rows);
    }

    /// The slot of a linear form at points.
    int slot_of(const LinearForm& form) {
        const auto found = std::ranges::find(c_.atoms, form);
        const auto place = static_cast<int>(found - c_.atoms.begin());
        if (found == c_.atoms.end()) c_.atoms.push_back(form);
        return first_atom + place;
    }

    static void add(const LinearForm& form, const SourceLocation& where, LinearForm& sum) {
        for (const auto& [derivative, coefficient] : form) {
            sum[derivative] += coefficient;
            require(std::isfinite(sum[derivative]), where,
                    "the coefficients of a field add up to {}; expected numbers below 1e308 in size", sum[derivative]);
        }
    }

    /// Moves the slopes of a function about the reference to the linear form, where they are finite.
    int without_slopes(const PointFunction& function, int node, LinearForm& linear) {
        if (!c_.is_continuous_at(function, slots_)) return node;
        for (const auto& [slot, slope] : function.slopes) {
            const double value = c_.slope_at(slope, slots_);
            if (value == 0.0 || !std::isfinite(value)) continue;
            for (const auto& [derivative, coefficient] : c_.form_of(slot))
                linear[{derivative.component, derivative.order + function.order}] += value * coefficient;
            const int part = graph_.make(Operation::multiply, graph_.number(value), graph_.slot(slot));
            node = graph_.make(Operation::subtract, node, part);
        }
        return node;
    }

    /// Functions that are equal, but for their sign, are one output; constants are sources.
    void collect_outputs() {
        std::map<int, std::size_t> output_of, force_of;  // node -> output
        for (const auto& [target, node] : remainders_) {
            const auto& [component, order] = target;
            const bool is_force = c_.in_balance(component);
            std::vector<RateFunction>& outputs = is_force ? c_.forces : c_.outputs;
            if (graph_.is_number(node)) {
                if (order == Order{}) c_.constants[static_cast<std::size_t>(component)] += graph_[node].value;
                continue;
            }
            const bool is_negative = graph_[node].operation == Operation::negate;
            const int bare = is_negative ? graph_[node].left : node;
            const auto [place, is_new] = (is_force ? force_of : output_of).emplace(bare, outputs.size());
            if (is_new) outputs.push_back({graph_.expression(bare), {}});
            outputs[place->second].uses.push_back({component, order, is_negative ? -1.0 : 1.0});
        }
        for (std::vector<RateFunction>* outputs : {&c_.outputs, &c_.forces})
            for (RateFunction& output : *outputs)
                if (output.uses.size() == 1 && output.uses[0].factor < 0.0) {
                    output.value = Expression(0.0) - output.value;
                    output.uses[0].factor = 1.0;
                }
    }

    /// Nothing that is evaluated reads a field that was substituted: a balance that was solved before did, if there is.
    void check_substitutes() const {
        const auto check = [&](const LinearForm& form) {
            for (const auto& [derivative, coefficient] : form)
                if (c_.is_substituted[c_.field(derivative.component)]) c_.reject_cycle(c_.field(derivative.component));
        };
        for (const LinearForm& row : c_.linear) check(row);
        for (const std::vector<RateFunction>* outputs : {&c_.outputs, &c_.forces})
            for (const RateFunction& output : *outputs)
                for (const int slot : c_.slots_read(output.value)) check(c_.form_of(slot));
        check_forces();
    }

    /// The products in a balance that is solved wave by wave are known before the fields of all such balances are.
    void check_forces() const {
        for (const RateFunction& force : c_.forces)
            for (const int slot : c_.slots_read(force.value))
                for (const auto& [derivative, coefficient] : c_.form_of(slot)) {
                    const Field& read = c_.model.fields[c_.field(derivative.component)];
                    const Field& held = c_.model.fields[c_.field(force.uses[0].component)];
                    require(!c_.in_balance(derivative.component), held.equation.where,
                            "the balance of {} has products with {}, which is in balance too, and is solved wave by "
                            "wave; expected products of fields with a rate",
                            held.symbol, read.symbol);
                }
    }

    /// The balances must determine their fields at every q.
    void check_balances() const {
        const std::vector<int>& held = c_.held;
        if (held.empty()) return;
        const Field& first = c_.model.fields[c_.field(held[0])];
        const SourceLocation& where = first.equation.text.empty() ? first.where : first.equation.where;
        std::vector<LinearForm> balances(c_.linear.size());
        for (const int k : held) balances[static_cast<std::size_t>(k)] = c_.linear[static_cast<std::size_t>(k)];
        require(c_.commutes_with_turns(balances), where,
                "the linear terms of the balance of {} distinguish directions; expected isotropic terms", first.symbol);
        for (const double q : {0.0, 0.31, 1.0, 2.7}) c_.check_balance_at(q);
    }

    CompiledEquations& c_;
    std::vector<double> slots_;
    GraphBuilder graph_{Folding::lenient};
    Remainders remainders_;
};
}  // namespace

void CompiledEquations::summarise(Term& term) const {
    TermSummary& summary = term.summary;
    std::set<int> reads, derives;
    const auto add = [&](const LinearForm& form) {
        for (const auto& [derivative, coefficient] : form) {
            reads.insert(derivative.component);
            if (derivative.order != Order{}) derives.insert(derivative.component);
        }
    };
    summary.vanishes_when_uniform = true;
    for (const Row& row : term.rows) {
        add(row.linear);
        for (const auto& [derivative, coefficient] : row.linear)
            if (derivative.order == Order{}) summary.vanishes_when_uniform = false;
        for (const PointFunction& function : row.functions) {
            if (function.order == Order{} && !vanishes(*this, function.value)) summary.vanishes_when_uniform = false;
            if (constant_value(function.value)) continue;
            summary.is_linear = false;
            const PointDegree found = degree_of(function.value);
            summary.degree = std::max(summary.degree, found.degree);
            summary.has_finite_degree = summary.has_finite_degree && found.is_finite;
            for (const int slot : slots_read(function.value)) add(form_of(slot));
        }
    }
    summary.reads.assign(reads.begin(), reads.end());
    summary.derives.assign(derives.begin(), derives.end());
}

// ---- the linear part and its remainder

void CompiledEquations::split(const UniformState& at) {
    about = at;
    linear.assign(static_cast<std::size_t>(components), {});
    constants.assign(static_cast<std::size_t>(components), 0.0);
    outputs.clear();
    forces.clear();
    degree = 1;
    has_finite_degree = true;
    held.clear();
    for (int k = 0; k < components; ++k)
        if (in_balance(k)) held.push_back(k);
    Splitting(*this).run();
    uniform_linear = form_symbol(linear, {0.0, 0.0}).real();
}

void CompiledEquations::reject_cycle(std::size_t index) const {
    const Field& field = model.fields[index];
    fail_input(field.equation.where,
               "the balance of {} has products, and depends on a balance that depends on {}; expected balances that "
               "can be solved one after the other",
               field.symbol, field.symbol);
}

}  // namespace drover::model
