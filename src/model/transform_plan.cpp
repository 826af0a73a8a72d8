// model/transform_plan.cpp: the fewest inputs of the functions at points, and the functions of them.
#include "model/transform_plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

namespace drover::model {

namespace {
/// Replaces slots by expressions.
Expression substituted(const Expression& expression, const std::map<int, Expression>& by) {
    GraphBuilder graph(Folding::lenient);
    std::vector<int> here;
    for (const Node& node : expression.graph().nodes) {
        const auto at = [&](int there) { return there < 0 ? -1 : here[static_cast<std::size_t>(there)]; };
        if (node.operation == Operation::number) here.push_back(graph.number(node.value));
        else if (node.operation == Operation::slot) here.push_back(graph.import(by.at(node.left).graph()).back());
        else here.push_back(graph.make(node.operation, at(node.left), at(node.right)));
    }
    return graph.expression(here.back());
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

}  // namespace

bool is_plain(const LinearForm& form) {
    return form.size() == 1 && form.begin()->first.order == Order{} && form.begin()->second == 1.0;
}

namespace {
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
}  // namespace

TransformPlan transform_plan(const CompiledEquations& c) {
    std::set<int> slots;
    for (const RateFunction& output : c.outputs) slots.merge(c.slots_read(output.value));
    std::vector<int> atoms;
    for (const int slot : slots)
        if (slot >= first_atom) atoms.push_back(slot);
    const auto form_of = [&](int slot) -> const LinearForm& {
        return c.atoms[static_cast<std::size_t>(slot - first_atom)];
    };
    std::stable_sort(atoms.begin(), atoms.end(), [&](int a, int b) {
        const auto key = [&](int slot) {
            return is_plain(form_of(slot)) ? form_of(slot).begin()->first.component : c.components;
        };
        return key(a) < key(b);
    });
    Basis basis;
    std::map<int, Expression> by;
    for (const int slot : {slot_x, slot_y, slot_t}) by.emplace(slot, slot_expression(slot));
    for (const int slot : atoms) {
        Expression sum(0.0);
        for (const auto& [member, coefficient] : basis.coefficients(form_of(slot)))
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

}  // namespace drover::model
