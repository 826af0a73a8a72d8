// model/algebra.hpp: formulas in vector notation as components: sums of derivatives of functions of points.
//
// A component is a linear form of the derivatives of fields, plus derivatives of functions at points:
//     sum_k c_k d_x^a d_y^b field_k + sum_n d_x^a d_y^b f_n(slots).
// The slots of the functions hold the position, the time and atoms: linear forms that are factors in products.
#pragma once
#include <algorithm>
#include <compare>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/expression_graph.hpp"
#include "drover/model/model.hpp"

namespace drover::model {

/// A derivative d_x^x d_y^y.
struct Order {
    int x = 0, y = 0;
    auto operator<=>(const Order&) const = default;
};
inline constexpr Order no_derivative{}, d_dx{1, 0}, d_dy{0, 1};
inline Order operator+(const Order& a, const Order& b) { return {a.x + b.x, a.y + b.y}; }

/// A derivative of one component of the fields, numbered through all fields.
struct Derivative {
    int component = 0;
    Order order = {};
    auto operator<=>(const Derivative&) const = default;
};
using LinearForm = std::map<Derivative, double>;

struct Component {
    LinearForm linear = {};
    std::map<Order, int> rest = {};  ///< nodes of the graph
};

/// What kind of quantity a value is: `indices` Cartesian indices, then a spin.  A vector has spin 1 and no index, the
/// gradient of a vector one index and spin 1.
struct Rank {
    int indices = 0, spin = 0;
    bool operator==(const Rank&) const = default;
};
inline constexpr Rank scalar{}, vector{0, 1};
enum class Parity {
    even,
    odd,
    none  ///< a component or a derivative along an axis: directions of space are named
};

/// Of a product.
inline Parity product_parity(Parity a, Parity b) {
    if (a == Parity::none || b == Parity::none) return Parity::none;
    return a == b ? Parity::even : Parity::odd;
}

struct Value {
    Rank rank = {};
    Parity parity = Parity::even;
    std::vector<Component> components = {};  ///< the indices first, the last one fastest
    std::vector<Component> imaginary = {};   ///< parts of a complex value; empty: it is real

    bool is_complex() const { return !imaginary.empty(); }
};

/// "a scalar", "a pseudovector", "a nematic (spin 2)".
std::string rank_text(const Rank& rank, Parity parity);

/// Coefficients of higher derivatives overflow, and no equation of physics has them.
inline constexpr int max_order = 32;

/// Position and time, then atoms.
inline constexpr int slot_x = 0, slot_y = 1, slot_t = 2, first_atom = 3;

/// A function that is no formula, of nodes.  Its values and, after each, the slopes by the arguments have slots.
struct FunctionCall {
    std::shared_ptr<const GivenFunction> function;
    std::vector<int> arguments;  ///< nodes
    int first = 0;               ///< slot of the first result

    int value_slot(int result) const { return first + result * (1 + static_cast<int>(arguments.size())); }
    int slope_slot(int result, int argument) const { return value_slot(result) + 1 + argument; }
    int end() const { return value_slot(function->results); }
};

/// Throws an input Error for another number of slopes than results times arguments.
std::vector<double> slopes_of(const GivenFunction& function, std::span<const double> arguments);

/// The derivative of a node, also through the calls, whose arguments are nodes of this graph, from the derivative of
/// each slot that holds no result of a call.  Throws an input Error at graph.where for a slope of a slope of a call.
int total_slope(GraphBuilder& graph, const std::vector<FunctionCall>& calls, int root,
                const std::function<int(int slot)>& slope_of_slot);

/// The call of which a slot holds a result or slope; nullptr without one.
template <class Call>
const Call* call_of(const std::vector<Call>& calls, int slot) {
    for (const Call& call : calls)
        if (slot >= call.first && slot < call.end()) return &call;
    return nullptr;
}

/// The linear form of an atom slot, from those of all; empty for a result of a call, a position and the time.
inline const LinearForm& form_of(const std::vector<LinearForm>& atoms, int slot) {
    static const LinearForm none;
    return slot < first_atom ? none : atoms[static_cast<std::size_t>(slot - first_atom)];
}

/// Operations on components in one graph.  Throws an input Error at graph.where as GraphBuilder does, for coefficients
/// that are not finite, and for derivatives of an order above max_order.
class Algebra {
public:
    Algebra() : graph(Folding::simplified) {}

    Component constant(double value);
    Component of_node(int node) const;  ///< a function at points
    /// The number that a component is, if it is one.
    std::optional<double> constant_of(const Component& a) const;
    bool is_zero(const Component& a) const { return a.linear.empty() && a.rest.empty(); }
    bool are_zero(const std::vector<Component>& all) const {
        return std::ranges::all_of(all, [this](const Component& one) { return is_zero(one); });
    }

    /// a + factor b.
    Component sum(const Component& a, const Component& b, double factor = 1.0);
    Component scaled(const Component& a, double factor);
    Component product(const Component& a, const Component& b);
    Component derivative(const Component& a, const Order& order);

    /// The component as one function at points: derivatives are carried out by the product rule.
    int at_points(const Component& a);
    /// The node of a linear form as a slot.
    int atom(const LinearForm& form);
    /// The nodes of the results of a function of nodes.
    std::vector<int> call(const std::shared_ptr<const GivenFunction>& function, const std::vector<int>& arguments);
    const std::vector<FunctionCall>& calls() const { return calls_; }
    int slope(int node, const std::function<int(int slot)>& slope_of_slot) {
        return total_slope(graph, calls_, node, slope_of_slot);
    }
    int slope_by(int node, int slot) {
        return slope(node, [&](int other) { return graph.number(other == slot ? 1.0 : 0.0); });
    }
    /// The slots of positions and linear forms that a node depends on, also through calls.
    std::set<int> slots_read(int node) const;
    /// The slope of a function at points in the direction x or y.
    int total_derivative(int node, const Order& direction);

    const LinearForm& form_of(int slot) const { return model::form_of(atoms_, slot); }
    int slots() const { return first_atom + static_cast<int>(atoms_.size()); }

    GraphBuilder graph;

private:
    bool reads_atoms(int node) const;
    void add(LinearForm& form, const Derivative& derivative, double coefficient) const;
    int differentiated(int node, const Order& order);

    std::vector<LinearForm> atoms_;
    std::map<LinearForm, int> slot_of_;
    std::vector<FunctionCall> calls_;
};

}  // namespace drover::model
