// model/balance.cpp: the drag and the force of a balance.
#include "model/balance.hpp"

#include <algorithm>

#include "model/conservation.hpp"

namespace drover::model {

bool has_products(const Algebra& algebra, const std::vector<Component>& total) {
    double number = 0.0;
    return !std::all_of(total.begin(), total.end(), [&](const Component& c) {
        return algebra.is_constant({{}, c.rest}, number);
    });
}

std::set<int> components_of(const Algebra& algebra, const std::vector<Component>& total) {
    std::set<int> read;
    const auto add = [&](const LinearForm& form) {
        for (const auto& [derivative, coefficient] : form) read.insert(derivative.component);
    };
    for (const Component& component : total) {
        add(component.linear);
        for (const auto& [order, node] : component.rest)
            for (const int slot : algebra.slots_read(node))
                if (slot >= first_atom) add(algebra.form_of(slot));
    }
    return read;
}

Value solved_balance(Algebra& algebra, const Field& field, int first, const std::vector<Component>& total) {
    const std::size_t width = total.size();
    Value value{{0, field.spin}, field.odd ? Parity::odd : Parity::even, {}};
    const auto is_own = [&](const Derivative& derivative) {
        return derivative.component >= first && derivative.component < first + static_cast<int>(width);
    };
    const auto reject = [&](const char* found) {
        fail_input(field.equation.where,
                   "the balance of {} has products, and {}; expected {} times functions of other fields, or "
                   "derivatives of it times numbers, plus functions of other fields",
                   field.symbol, found, field.symbol);
    };
    if (field.solenoidal) reject("some of them are with itself, which is solenoidal");
    for (std::size_t k = 0; k < width; ++k) {
        LinearForm others = total[k].linear;
        const double own = others[{first + static_cast<int>(k), {}}];
        others.erase({first + static_cast<int>(k), {}});
        for (const auto& [derivative, coefficient] : others)
            if (is_own(derivative)) reject("derivatives or other components of it");
        const int rest = algebra.at_points({{}, total[k].rest});
        int slope = algebra.graph.number(0.0);
        Expression without = algebra.graph.expression(rest);
        for (const int slot : algebra.slots_read(rest)) {
            if (slot < first_atom) continue;
            const LinearForm& form = algebra.form_of(slot);
            if (std::none_of(form.begin(), form.end(), [&](const auto& entry) { return is_own(entry.first); }))
                continue;
            if (form.size() != 1 || form.begin()->first != Derivative{first + static_cast<int>(k), {}})
                reject("derivatives or other components of it");
            slope = algebra.slope(rest, [&](int other) { return algebra.graph.number(other == slot ? 1.0 : 0.0); });
            if (algebra.slots_read(slope).count(slot) > 0) reject("is not linear in it");
            without = bind(without, slot, 0.0, field.equation.where);
        }
        const int drag =
            algebra.graph.make(Operation::negate, algebra.graph.make(Operation::add, algebra.graph.number(own), slope));
        if (algebra.graph.is_number(drag, 0.0)) reject("no term of it");
        const int force =
            algebra.graph.make(Operation::add, algebra.atom(others), algebra.graph.import(without.graph()).back());
        value.components.push_back(algebra.of_node(algebra.graph.make(Operation::divide, force, drag)));
    }
    return value;
}

void check_free_mean(Algebra& algebra, const Field& field, const std::vector<Component>& total,
                     const std::function<bool(int component)>& is_in_balance, const std::vector<int>& solenoidal) {
    for (const Component& component : total) {
        const bool has_drag = std::any_of(component.linear.begin(), component.linear.end(), [&](const auto& entry) {
            return entry.first.order == no_derivative && is_in_balance(entry.first.component);
        });
        const auto found = component.rest.find(no_derivative);
        double number = 0.0;
        if (has_drag || found == component.rest.end()) continue;
        const Component source{{}, {*found}};
        require(algebra.is_constant(source, number) || is_divergence(algebra, source, solenoidal), field.equation.where,
                "the balance of {} leaves its mean free, and its products have a mean; expected products that are "
                "divergences, or a term such as -c {}",
                field.symbol, field.symbol);
    }
}

}  // namespace drover::model
