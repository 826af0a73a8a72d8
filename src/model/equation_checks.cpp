// model/equation_checks.cpp: checks of fields, the Euler operator of a rate, the drag and the force of a balance.
#include <algorithm>
#include <cmath>

#include "model/summands.hpp"

namespace drover::model {

void check_fields(const Model& model) {
    constexpr std::size_t max_fields = 64;  // symbols are dense matrices
    require(model.fields.size() <= max_fields, model.fields.empty() ? SourceLocation{} : model.fields.back().where,
            "the model has {} fields; expected at most {}", model.fields.size(), max_fields);
    for (const auto& [name, value] : model.coefficients)
        require(std::isfinite(value), {}, "the coefficient {} is {}; expected a finite number", name, value);
    for (const Field& field : model.fields) {
        require(std::isfinite(field.noise) && field.noise >= 0.0, field.where,
                "the noise of {} is {}; expected a finite number >= 0", field.name, field.noise);
        require(std::isfinite(field.reference), field.where, "the reference of {} is {}; expected a finite number",
                field.name, field.reference);
        require(field.reference == 0.0 || (field.spin == 0 && !field.odd), field.where,
                "the reference of {}, which is {}, is {}; expected 0, the isotropic state", field.name,
                rank_text({0, field.spin}, field.odd ? Parity::odd : Parity::even), field.reference);
        const bool is_held = field.left == LeftSide::balance;
        require(!is_held || (field.noise == 0.0 && field.mass.text.empty()), field.where,
                "{} is in balance and has a {}; expected none, since it has no rate", field.name,
                field.noise != 0.0 ? "noise" : "mass");
        require(!field.solenoidal || field.spin == 1, field.where,
                "{} is declared as solenoidal, and is {}; expected a vector", field.name,
                rank_text({0, field.spin}, field.odd ? Parity::odd : Parity::even));
        require(!field.solenoidal || field.further.empty(), field.where,
                "{} is declared as solenoidal, and has terms that are written apart; expected one equation",
                field.name);
        require(!field.conserved || field.noise == 0.0 || field.noise_conserves, field.where,
                "{} is conserved, and its noise is not; expected conserved_noise = true", field.name);
    }
}

namespace {
/// body(slot, form) for each linear form of the fields that a node reads.
template <class Body>
void for_forms(const Algebra& algebra, int node, Body body) {
    for (const int slot : algebra.slots_read(node))
        if (slot >= first_atom) body(slot, algebra.form_of(slot));
}

/// A divergence of fields vanishes where they are uniform; a given source does not.
bool has_uniform_value(const Algebra& algebra, int node) {
    const Expression source = algebra.graph.expression(node);
    const std::set<int> slots = algebra.slots_read(node);
    const bool reads_position = slots.count(slot_x) + slots.count(slot_y) > 0,
               reads_fields = !slots.empty() && *slots.rbegin() >= first_atom;
    if (reads_position && reads_fields) return false;  // not known: "cos(x) phi + sin(x) d_x phi" is a divergence
    std::vector<double> values(static_cast<std::size_t>(algebra.slots()), 0.0);
    values[slot_x] = 0.37, values[slot_y] = 0.83, values[slot_t] = 0.59;
    double size = 0.0;
    for (int slot = first_atom; slot < algebra.slots(); ++slot)
        for (const auto& [derivative, coefficient] : algebra.form_of(slot))
            if (derivative.order == Order{}) {
                values[static_cast<std::size_t>(slot)] += coefficient * (0.7 + 0.11 * derivative.component);
                size = std::max(size, std::abs(coefficient));
            }
    return !(std::abs(evaluate(source, values)) <= 1e-12 * size);
}

/// Whether a component is the divergence of something, whatever the fields: its Euler operator vanishes identically.
/// Tried at random derivatives of the fields.
bool is_divergence(Algebra& algebra, const Component& source, const std::vector<int>& solenoidal) {
    const int node = algebra.at_points(source);
    if (has_uniform_value(algebra, node)) return false;
    // The first component of a divergence-free vector stands for its stream function: v = (-d_y psi, d_x psi).
    const auto stream_of = [&](int component) {
        for (const int first : solenoidal)
            if (component == first || component == first + 1) return first;
        return -1;
    };
    std::map<int, std::vector<int>> euler;  // of each component: summands
    for_forms(algebra, node, [&](int slot, const LinearForm form) {
        const int slope = algebra.slope_by(node, slot);
        for (const auto& [derivative, coefficient] : form) {
            const double sign = (derivative.order.x + derivative.order.y) % 2 == 0 ? 1.0 : -1.0;
            Component part = algebra.scaled(algebra.of_node(slope), sign * coefficient);
            part = algebra.derivative(part, derivative.order);
            const int stream = stream_of(derivative.component);
            if (stream >= 0) {
                const bool is_x = derivative.component == stream;
                part = algebra.scaled(algebra.derivative(part, is_x ? d_dy : d_dx), is_x ? 1.0 : -1.0);
            }
            euler[stream >= 0 ? stream : derivative.component].push_back(algebra.at_points(part));
        }
    });
    std::uint64_t random = 88172645463325252u;
    const auto next = [&random] {
        random ^= random << 13u;
        random ^= random >> 7u;
        random ^= random << 17u;
        return 0.5 + static_cast<double>(random >> 11u) * 0x1p-53;
    };
    for (int trial = 0; trial < 3; ++trial) {
        std::map<Derivative, double> values;
        const auto value_of = [&](const Derivative& derivative) {
            const int stream = stream_of(derivative.component);
            const bool is_x = derivative.component == stream;
            const Derivative of = stream < 0 ? derivative : Derivative{stream, derivative.order + (is_x ? d_dy : d_dx)};
            const auto [place, is_new] = values.emplace(of, 0.0);
            if (is_new) place->second = next();
            return is_x ? -place->second : place->second;
        };
        std::vector<double> slots(static_cast<std::size_t>(algebra.slots()), 0.3);
        for (int slot = first_atom; slot < algebra.slots(); ++slot)
            for (const auto& [derivative, coefficient] : algebra.form_of(slot))
                slots[static_cast<std::size_t>(slot)] =
                    (derivative == algebra.form_of(slot).begin()->first ? 0.0 : slots[static_cast<std::size_t>(slot)]) +
                    coefficient * value_of(derivative);
        for (const auto& [component, summands] : euler) {
            double sum = 0.0, size = 0.0;
            for (const int summand : summands) {
                const double value = evaluate(algebra.graph.expression(summand), slots);
                sum += value;
                size += std::abs(value);
            }
            if (!std::isfinite(size) || std::abs(sum) > 1e-9 * size) return false;
        }
    }
    return true;
}
}  // namespace

void check_conserved(Algebra& algebra, const Field& field, const std::vector<Summand>& parts,
                     const std::vector<int>& solenoidal) {
    require(field.spin == 0, field.where, "{} is conserved and has spin {}; expected a scalar", field.name, field.spin);
    require(field.left == LeftSide::rate, field.where, "{} is conserved and in balance; expected a field with a rate",
            field.name);
    const Summand* first = nullptr;  // of the parts that are no divergences, which together may be one
    Component total;
    for (const Summand& part : parts) {
        for (const LinearForm& row : part.noise)
            for (const auto& [derivative, coefficient] : row)
                require(derivative.order != Order{}, part.summary.where,
                        "the noise \"{}\" is no divergence, and {} is declared as conserved; expected a divergence "
                        "such as div xi, or conserved = false",
                        part.summary.text, field.symbol);
        const Component& rate = part.value.components[0];
        Component source{rate.linear, {}};  // what is no derivative as a whole
        std::erase_if(source.linear, [](const auto& entry) { return entry.first.order != Order{}; });
        if (const auto found = rate.rest.find(Order{}); found != rate.rest.end()) source.rest.insert(*found);
        if (algebra.is_zero(source) || is_divergence(algebra, source, solenoidal)) continue;
        if (first == nullptr) first = &part;
        total = algebra.sum(total, source);
    }
    require(first == nullptr || algebra.is_zero(total) || is_divergence(algebra, total, solenoidal),
            first == nullptr ? field.where : first->summary.where,
            "the term \"{}\" is no divergence, and {} is declared as conserved; expected a divergence such as "
            "-div(...), or conserved = false",
            first == nullptr ? "" : first->summary.text, field.symbol);
}

bool has_products(const Algebra& algebra, const std::vector<Component>& total) {
    return std::ranges::any_of(total, [&](const Component& c) { return !algebra.constant_of({{}, c.rest}); });
}

std::set<int> components_of(const Algebra& algebra, const std::vector<Component>& total) {
    std::set<int> read;
    const auto add = [&](const LinearForm& form) {
        for (const auto& [derivative, coefficient] : form) read.insert(derivative.component);
    };
    for (const Component& component : total) {
        add(component.linear);
        for (const auto& [order, node] : component.rest)
            for_forms(algebra, node, [&](int, const LinearForm& form) { add(form); });
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
        for_forms(algebra, rest, [&](int slot, const LinearForm& form) {
            if (std::ranges::none_of(form, [&](const auto& entry) { return is_own(entry.first); })) return;
            if (form.size() != 1 || form.begin()->first != Derivative{first + static_cast<int>(k), {}})
                reject("derivatives or other components of it");
            slope = algebra.slope_by(rest, slot);
            if (algebra.slots_read(slope).count(slot) > 0) reject("is not linear in it");
            without = bind(without, slot, 0.0, field.equation.where);
        });
        const int drag =
            algebra.graph.make(Operation::negate, algebra.graph.make(Operation::add, algebra.graph.number(own), slope));
        if (algebra.graph.is_number(drag, 0.0)) reject("no term of it");
        const int force =
            algebra.graph.make(Operation::add, algebra.atom(others), algebra.graph.import(without.graph()));
        value.components.push_back(algebra.of_node(algebra.graph.make(Operation::divide, force, drag)));
    }
    return value;
}

void check_free_mean(Algebra& algebra, const Field& field, const std::vector<Component>& total,
                     const std::function<bool(int component)>& is_in_balance, const std::vector<int>& solenoidal) {
    for (const Component& component : total) {
        const bool has_drag = std::ranges::any_of(component.linear, [&](const auto& entry) {
            return entry.first.order == no_derivative && is_in_balance(entry.first.component);
        });
        const auto found = component.rest.find(no_derivative);
        if (has_drag || found == component.rest.end()) continue;
        const Component source{{}, {*found}};
        require(algebra.constant_of(source) || is_divergence(algebra, source, solenoidal), field.equation.where,
                "the balance of {} leaves its mean free, and its products have a mean; expected products that are "
                "divergences, or a term such as -c {}",
                field.symbol, field.symbol);
    }
}

}  // namespace drover::model
