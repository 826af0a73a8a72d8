// model/conservation.cpp: the Euler operator of a rate.
#include "model/conservation.hpp"

#include <cmath>
#include <set>

namespace drover::model {

namespace {
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
}  // namespace

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
    for (const int slot : algebra.slots_read(node)) {
        if (slot < first_atom) continue;
        const int slope =
            algebra.slope(node, [&](int other) { return algebra.graph.number(other == slot ? 1.0 : 0.0); });
        const LinearForm form = algebra.form_of(slot);
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
    }
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

}  // namespace drover::model
