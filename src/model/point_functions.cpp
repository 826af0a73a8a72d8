// model/point_functions.cpp: degrees of the nodes of an expression; the fewest inputs of the functions at points, and
// these for a few points at a time: all that they read is then in the first-level cache.
#include "model/point_functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "model/compiled.hpp"

namespace drover::model {

namespace {
/// Replaces slots by expressions.
Expression substituted(const Expression& expression, const std::map<int, Expression>& by) {
    GraphBuilder graph(Folding::lenient);
    return graph.expression(
        graph.import(expression.graph(), [&](int slot) { return graph.import(by.at(slot).graph()); }));
}
Expression slot_expression(int slot) {
    GraphBuilder graph(Folding::exact);
    return graph.expression(graph.slot(slot));
}

/// A basis of linear forms: each further form is a combination of earlier ones or extends it.
class Basis {
public:
    /// The coefficients of a form in the basis; extends the basis if there are none.
    std::vector<std::pair<std::size_t, double>> coefficients(const LinearForm& form) {
        LinearForm rest = form;
        std::map<std::size_t, double> of_members;
        for (const Reduced& row : reduced_) {
            const auto pivot = rest.find(row.pivot);
            if (pivot == rest.end()) continue;
            const double factor = pivot->second / row.form.at(row.pivot);
            for (const auto& [derivative, value] : row.form) {
                double& left = rest[derivative];
                left -= factor * value;
                if (std::abs(left) <= 1e-12 * std::abs(factor * value)) rest.erase(derivative);  // rounding
            }
            rest.erase(row.pivot);
            for (const auto& [member, value] : row.of_members) of_members[member] += factor * value;
        }
        if (!rest.empty()) {
            Reduced row{rest, rest.begin()->first, {}};
            for (const auto& [member, value] : of_members) row.of_members[member] = -value;
            row.of_members[members.size()] = 1.0;
            reduced_.push_back(row);
            of_members = {{members.size(), 1.0}};
            members.push_back(form);
        }
        return {of_members.begin(), of_members.end()};
    }
    std::vector<LinearForm> members;

private:
    struct Reduced {
        LinearForm form;
        Derivative pivot;
        std::map<std::size_t, double> of_members;
    };
    std::vector<Reduced> reduced_;
};

/// The slots of results that expressions read, also through other calls.
std::set<int> results_read(const CompiledEquations& c) {
    std::set<int> found;
    std::function<void(const Expression&)> add = [&](const Expression& value) {
        for (const int slot : slots_of(value)) {
            const Call* call = c.call_at(slot);
            if (call == nullptr || !found.insert(slot).second) continue;
            for (const Expression& argument : call->values) add(argument);
        }
    };
    for (const RateFunction& output : c.outputs) add(output.value);
    return found;
}

constexpr std::size_t max_points = 256;
using Values = std::array<double, max_points>;

/// What a field is damped by about the references [mass/time]: minus the slope of its own force.
double drag_of(const CompiledEquations& c, std::size_t field, double mass, const std::vector<double>& slots) {
    const Derivative own{c.first_component[field], {}};
    double slope = 0.0;
    const auto add = [&](const Derivative& derivative, double value) {
        if (derivative == own && std::isfinite(value)) slope += value;
    };
    for (const Term& term : c.terms) {
        if (term.summary.field != field || term.summary.is_placed) continue;
        for (const auto& [derivative, coefficient] : term.rows[0].linear) add(derivative, coefficient);
        for (const PointFunction& function : term.rows[0].functions)
            for (const PointFunction::Slope& by : function.slopes)
                for (const auto& [derivative, coefficient] : c.form_of(by.slot))
                    if (function.order == Order{}) add(derivative, evaluate(by.value, slots) * coefficient);
    }
    return std::max(0.0, -slope * mass);
}

/// mass -> 1/(mass^16 + floor^16)^(1/16).
void invert(double floor, std::size_t size, const double* mass, double* inverse) {
    if (floor == 0.0) {
        for (std::size_t i = 0; i < size; ++i) inverse[i] = 1.0 / mass[i];
        return;
    }
    double min_mass = INFINITY;
    for (std::size_t i = 0; i < size; ++i) min_mass = mass[i] < min_mass ? mass[i] : min_mass;
    const auto sixteenth = [](double ratio) {
        const double square = ratio * ratio, fourth = square * square, eighth = fourth * fourth;
        return eighth * eighth;
    };
    if (floor <= 0.25 * min_mass) {  // 1 - x/16 is (1 + x)^(-1/16) to less than 1e-20, and costs no roots
        for (std::size_t i = 0; i < size; ++i) {
            const double over = 1.0 / mass[i];
            inverse[i] = over - over * sixteenth(floor * over) * 0.0625;
        }
        return;
    }
    for (std::size_t i = 0; i < size; ++i)
        inverse[i] = 1.0 / (mass[i] * std::sqrt(std::sqrt(std::sqrt(std::sqrt(1.0 + sixteenth(floor / mass[i]))))));
}
}  // namespace

bool is_plain(const LinearForm& form) {
    return form.size() == 1 && form.begin()->first.order == Order{} && form.begin()->second == 1.0;
}

TransformPlan transform_plan(const CompiledEquations& c) {
    std::set<int> slots;
    for (const RateFunction& output : c.outputs) slots.merge(c.slots_read(output.value));
    std::vector<int> atoms;
    for (const int slot : slots)
        if (slot >= first_atom) atoms.push_back(slot);
    std::ranges::stable_sort(atoms, [&](int a, int b) {
        const auto key = [&](int slot) {
            return is_plain(c.form_of(slot)) ? c.form_of(slot).begin()->first.component : c.components;
        };
        return key(a) < key(b);
    });
    Basis basis;
    std::map<int, Expression> by;
    for (const int slot : {slot_x, slot_y, slot_t}) by.emplace(slot, slot_expression(slot));
    for (const int slot : atoms) {
        Expression sum(0.0);
        for (const auto& [member, coefficient] : basis.coefficients(c.form_of(slot)))
            sum = sum + Expression(coefficient) * slot_expression(first_atom + static_cast<int>(member));
        by.emplace(slot, sum);
    }
    TransformPlan plan{basis.members, {}, {}, first_atom + static_cast<int>(basis.members.size())};
    const std::set<int> results = results_read(c);
    for (std::size_t n = 0; n < c.calls.size(); ++n) {
        const Call& call = c.calls[n];
        TransformPlan::Function function{.call = n, .arguments = {}, .results = {}, .first = plan.slots};
        for (int slot = call.first; slot < call.end(); ++slot) {
            if (results.count(slot) == 0) continue;
            function.results.push_back(slot - call.first);
            by.emplace(slot, slot_expression(plan.slots++));
        }
        if (function.results.empty()) continue;
        for (const Expression& argument : call.values) function.arguments.push_back(substituted(argument, by));
        plan.functions.push_back(std::move(function));
    }
    for (const RateFunction& output : c.outputs) plan.values.push_back(substituted(output.value, by));
    plan.values = factored(plan.values);
    return plan;
}

std::shared_ptr<const CompiledEquations> with_forces_as_outputs(const CompiledEquations& equations) {
    auto c = std::make_shared<CompiledEquations>(equations);
    c->outputs = std::move(c->forces);
    c->forces.clear();
    c->products.clear();
    c->is_isotropic = true;  // nothing of the linear part is left to them
    return c;
}

TransformCount transforms_of(const CompiledEquations& equations) {
    const TransformPlan plan = transform_plan(equations);
    TransformCount count{static_cast<int>(plan.inputs.size()), static_cast<int>(plan.values.size())};
    const auto add = [&count](const CompiledEquations& others) {
        const TransformCount more = transforms_of(others);
        count.inverse += more.inverse;
        count.forward += more.forward;
    };
    if (!equations.forces.empty()) add(*with_forces_as_outputs(equations));
    for (const NoiseProducts& one : equations.products) add(*one.equations);
    return count;
}

/// Values of the slots at the points, and where those of results and arguments are.
struct PointFunctions::Rows {
    std::vector<const double*> slots;
    std::vector<double> uniform;
    std::vector<Values> results, arguments;
    Values x, y;
    double* result(int slot, int first) { return results[static_cast<std::size_t>(slot - first)].data(); }
};

PointFunctions::PointFunctions(const CompiledEquations& equations, const TransformPlan& plan,
                               const numerics::Grid& grid)
    : grid_(grid), inputs_(plan.inputs.size()), slots_(plan.slots), program_(plan.values) {
    std::vector<Expression> all = plan.values;
    for (const TransformPlan::Function& function : plan.functions) {
        all.insert(all.end(), function.arguments.begin(), function.arguments.end());
        add_call(function, equations.calls[function.call]);
        for (std::size_t n = 0; n < equations.masses.size(); ++n)
            if (equations.masses[n].call == function.call) calls_.back().inverse = static_cast<int>(n);
    }
    for (const Expression& value : all)
        for (const int slot : slots_of(value)) reads_position_ = reads_position_ || slot == slot_x || slot == slot_y;
    if (equations.masses.empty()) return;
    const std::vector<double> slots = equations.slots_at(equations.reference());
    for (const Mass& mass : equations.masses) {
        const double value = evaluate(equations.calls[mass.call].values[0], slots);
        masses_.push_back(
            {.field = mass.field, .reference = value, .drag = drag_of(equations, mass.field, value, slots)});
    }
}

void PointFunctions::add_call(const TransformPlan::Function& function, const Call& call) {
    Evaluated one{.function = call.function};
    for (const Expression& argument : function.arguments) {
        const Node& node = argument.graph().nodes.back();
        const bool is_slot = node.operation == Operation::slot, is_number = node.operation == Operation::number;
        one.slots.push_back(is_slot ? node.left : -1);
        one.numbers.push_back(is_number ? node.value : 0.0);
        one.programs.push_back(is_slot || is_number
                                   ? nullptr
                                   : std::make_shared<const StripProgram>(std::span(&argument, std::size_t{1})));
    }
    const auto slot_of = [&](int slot) {
        const auto found = std::ranges::find(function.results, slot - call.first);
        return found == function.results.end() ? -1
                                               : function.first + static_cast<int>(found - function.results.begin());
    };
    for (int k = 0; k < call.function->results; ++k) {
        one.values.push_back(slot_of(call.value_slot(k)));
        for (int a = 0; a < static_cast<int>(call.arguments.size()); ++a)
            one.slopes.push_back(slot_of(call.slope_slot(k, a)));
    }
    calls_.push_back(std::move(one));
}

void PointFunctions::call(const Evaluated& one, std::size_t size, Rows& rows) const {
    const int first = first_atom + static_cast<int>(inputs_);
    std::vector<PointArgument> arguments;
    for (std::size_t a = 0; a < one.slots.size(); ++a) {
        PointArgument argument{.number = one.numbers[a]};
        if (one.slots[a] == slot_t) argument.number = rows.uniform[slot_t];
        else if (one.slots[a] >= 0) argument.values = rows.slots[static_cast<std::size_t>(one.slots[a])];
        else if (one.programs[a] != nullptr) {
            if (rows.arguments.size() < one.slots.size()) rows.arguments.resize(one.slots.size());
            double* const to = rows.arguments[a].data();
            one.programs[a]->write(size, rows.slots, rows.uniform, std::span(&to, std::size_t{1}));
            argument.values = to;
        }
        arguments.push_back(argument);
    }
    if (one.inverse >= 0 && one.values[0] >= 0 && arguments[0].values != nullptr) {
        invert(masses_[static_cast<std::size_t>(one.inverse)].floor, size, arguments[0].values,
               rows.result(one.values[0], first));
    } else {
        std::array<Values, 2> unread;
        std::array<double*, 2> out{};
        for (std::size_t k = 0; k < one.values.size(); ++k)
            out[k] = one.values[k] >= 0 ? rows.result(one.values[k], first) : unread[k].data();
        one.function->values(size, arguments, std::span(out).first(one.values.size()));
    }
    if (std::ranges::all_of(one.slopes, [](int slot) { return slot < 0; })) return;
    std::vector<double> point(arguments.size());
    for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t a = 0; a < point.size(); ++a)
            point[a] = arguments[a].values ? arguments[a].values[i] : arguments[a].number;
        const std::vector<double> slopes = slopes_of(*one.function, point);
        for (std::size_t n = 0; n < slopes.size(); ++n)
            if (one.slopes[n] >= 0) rows.result(one.slopes[n], first)[i] = slopes[n];
    }
}

void PointFunctions::write(double t, const numerics::Strip& strip) const {
    const std::size_t step = reads_position_ || !calls_.empty() ? max_points : strip.size;
    const int first = first_atom + static_cast<int>(inputs_);
    Rows rows;
    rows.slots.assign(static_cast<std::size_t>(slots_), nullptr);
    rows.uniform.assign(static_cast<std::size_t>(slots_), 0.0);
    rows.uniform[slot_t] = t;
    rows.results.resize(static_cast<std::size_t>(slots_ - first));
    for (int slot = first; slot < slots_; ++slot) rows.slots[static_cast<std::size_t>(slot)] = rows.result(slot, first);
    std::vector<double*> out(strip.out.size());
    for (std::size_t begin = 0; begin < strip.size; begin += step) {
        const std::size_t size = std::min(step, strip.size - begin);
        for (std::size_t i = 0; i < inputs_; ++i) rows.slots[first_atom + i] = strip.in[i] + begin;
        for (std::size_t k = 0; k < out.size(); ++k) out[k] = strip.out[k] + begin;
        if (reads_position_) {
            const auto width = static_cast<std::size_t>(grid_.nx);
            for (std::size_t i = 0; i < size; ++i) {
                rows.x[i] = grid_.lx / grid_.nx * static_cast<double>((strip.first + begin + i) % width);
                rows.y[i] = grid_.ly / grid_.ny * static_cast<double>((strip.first + begin + i) / width);
            }
            rows.slots[slot_x] = rows.x.data();
            rows.slots[slot_y] = rows.y.data();
        }
        for (const Evaluated& one : calls_) call(one, size, rows);
        program_.write(size, rows.slots, rows.uniform, out);
    }
}

void PointFunctions::set_step(double dt) {
    for (Inverse& mass : masses_) mass.floor = std::min(mass.drag * dt, 0.5 * mass.reference);
}

double PointFunctions::mass_floor(std::size_t field) const {
    for (const Inverse& mass : masses_)
        if (mass.field == field) return mass.floor / mass.reference;
    return 0.0;
}

PointDegree point_degree(const Expression& expression,
                         const std::function<std::optional<PointDegree>(int)>& of_result) {
    constexpr int max_degree = 1000;
    const std::vector<Node>& nodes = expression.graph().nodes;
    std::vector<PointDegree> degrees;
    for (const Node& node : nodes) {
        const auto of = [&](int index) {
            return index < 0 ? PointDegree{0, true} : degrees[static_cast<std::size_t>(index)];
        };
        const bool is_leaf_node = is_leaf(node);
        const PointDegree a = is_leaf_node ? PointDegree{0, true} : of(node.left),
                          b = is_leaf_node ? PointDegree{0, true} : of(node.right);
        PointDegree found{0, a.is_finite && b.is_finite};
        switch (node.operation) {
            case Operation::number: break;
            case Operation::slot:
                found.degree = node.left == slot_t ? 0 : 1;
                found.is_finite = node.left >= first_atom || node.left == slot_t;
                if (const auto result = of_result(node.left)) found = *result;
                break;
            case Operation::add:
            case Operation::subtract: found.degree = std::max(a.degree, b.degree); break;
            case Operation::negate: found.degree = a.degree; break;
            case Operation::multiply: found.degree = a.degree + b.degree; break;
            case Operation::divide:
                found.degree = a.degree + b.degree;
                found.is_finite = found.is_finite && b.degree == 0;
                break;
            case Operation::power: {
                const Node& exponent = nodes[static_cast<std::size_t>(node.right)];
                const bool is_natural = exponent.operation == Operation::number && exponent.value >= 0.0 &&
                                        exponent.value == std::floor(exponent.value);
                if (is_natural) found.degree = static_cast<int>(std::min(a.degree * exponent.value, 1.0 * max_degree));
                else if (a.degree + b.degree > 0) found = {std::max(2, a.degree), false};
                break;
            }
            default:
                if (a.degree + b.degree > 0) found = {std::max({2, a.degree, b.degree}), false};
                break;
        }
        found.degree = std::min(found.degree, max_degree);
        degrees.push_back(found);
    }
    return {std::max(1, degrees.back().degree), degrees.back().is_finite};
}

}  // namespace drover::model
