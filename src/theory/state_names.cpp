// theory/state_names.cpp: uniform states in words, and their names, by their order and by what drives it.
#include "theory/state_names.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/text.hpp"
#include "numerics/algebra/dense.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

namespace {
Eigen::Vector2d vector_at(const model::UniformState& state, int component) {
    return {state[static_cast<std::size_t>(component)], state[static_cast<std::size_t>(component) + 1]};
}

/// The rate of the order where it is 0 and all other fields follow: one step of Newton's method from the references.
/// Zero where it is a rounding error, or the order has no rate.
Eigen::Vector2d push_on_order(const UniformEquations& equations, int order) {
    const std::vector<int>& state = equations.equations().state_components();
    const auto found = std::ranges::find(state, order);
    if (found == state.end()) return Eigen::Vector2d::Zero();
    const Eigen::Index first = found - state.begin(), count = equations.count();
    std::vector<Eigen::Index> others;
    for (Eigen::Index k = 0; k < count; ++k)
        if (k != first && k != first + 1) others.push_back(k);
    const Eigen::MatrixXd slopes = equations.jacobian(equations.reference()).topRows(count);
    const Eigen::VectorXd rates = equations.values(equations.reference()).head(count);
    if (!slopes.allFinite() || !rates.allFinite()) return Eigen::Vector2d::Zero();
    Eigen::Vector2d push = rates.segment<2>(first);
    double size = push.norm();
    if (!others.empty()) {
        const Eigen::MatrixXd by_others = slopes.middleRows(first, 2)(Eigen::all, others);
        const Eigen::VectorXd answer = -numerics::shortest_solution(Eigen::MatrixXd(slopes(others, others)),
                                                                    Eigen::VectorXd(rates(others)), 1e-12);
        push += by_others * answer;
        size += (by_others.cwiseAbs() * answer.cwiseAbs()).norm();
    }
    if (push.norm() <= 1e-12 * size) return Eigen::Vector2d::Zero();
    return push;
}

/// Distinguishes states of one name by the values that differ.
void name_by_values(const model::Model& model, std::vector<StationaryState>& states) {
    std::vector<std::string> names;
    for (const model::Field& field : model.fields)
        for (const std::string& name : model::component_names(field)) names.push_back(name);
    for (const char* const common : {"isotropic", "ordered"}) {
        std::vector<StationaryState*> alike;
        for (StationaryState& state : states)
            if (state.name == common) alike.push_back(&state);
        if (alike.size() < 2) continue;
        for (std::size_t k = 0, listed = 0; k < names.size(); ++k) {
            const auto differs = [&](const StationaryState* state) {
                return std::abs(state->values[k] - alike[0]->values[k]) > 1e-9 * std::abs(alike[0]->values[k]);
            };
            if (std::ranges::none_of(alike, differs)) continue;
            for (StationaryState* state : alike)
                state->name += text("{} {} = {:.4g}", listed == 0 ? ":" : ",", names[k], state->values[k]);
            ++listed;
        }
    }
}

/// Names states whose order is along a field or against it; false if one is neither.
bool name_by_field(const Eigen::Vector2d& field, int order, std::vector<StationaryState>& states) {
    const Eigen::Vector2d axis = field.normalized();
    const auto along = [&](const StationaryState& state) { return vector_at(state.values, order).dot(axis); };
    for (const StationaryState& state : states) {
        const Eigen::Vector2d p = vector_at(state.values, order);
        if (p.norm() == 0.0 || std::abs(p.x() * axis.y() - p.y() * axis.x()) > 1e-9 * p.norm()) return false;
    }
    std::ranges::stable_sort(states,
                             [&](const StationaryState& a, const StationaryState& b) { return along(a) > along(b); });
    for (StationaryState& state : states) {
        // Of two on one side the one with less order has a name of its own.
        const bool has_less = std::ranges::any_of(states, [&](const StationaryState& other) {
            return (along(other) > 0.0) == (along(state) > 0.0) && std::abs(along(other)) > std::abs(along(state));
        });
        state.name = text("{}{} the field", has_less ? "weakly " : "", along(state) > 0.0 ? "along" : "against");
    }
    return true;
}
}  // namespace

void name_states(const UniformEquations& equations, std::vector<StationaryState>& states) {
    const std::vector<int> turning = model::turning_components(equations.model());
    if (!turning.empty() && !equations.turns_freely() && !states.empty()) {
        const Eigen::Vector2d field = push_on_order(equations, turning.front());
        if (field.norm() > 0.0 && name_by_field(field, turning.front(), states)) return;
    }
    for (StationaryState& state : states) {
        // What a source moves, as beads that drift under a force, is no order.
        const bool only_drifts =
            !turning.empty() && !equations.turns_freely() && vector_at(state.values, turning.front()).norm() == 0.0;
        state.name = state.is_isotropic || only_drifts ? "isotropic" : "ordered";
    }
    name_by_values(equations.model(), states);
}

bool is_given(const model::Field& field) { return field.spin == 0 && !field.observed.counted.empty(); }

std::string values_text(const model::Model& model, const model::UniformState& values) {
    const std::vector<int> firsts = model::first_components(model);
    std::string result;
    for (const std::size_t n : model::drawn_fields(model)) {
        const model::Field& field = model.fields[n];
        const auto at = static_cast<std::size_t>(firsts[n]);
        const double value = field.spin == 0 ? values[at] : std::hypot(values[at], values[at + 1]);
        if (value != 0.0 && !is_given(field))
            result += text("{}{} = {:.6g}", result.empty() ? "" : ", ",
                           field.spin == 0 ? field.symbol : "|" + field.symbol + "|", value);
    }
    return result;
}

std::string state_text(const model::Model& model, const model::UniformState& values) {
    const std::string result = values_text(model, values);
    return result.empty() ? "all fields 0" : result;
}

std::string state_words(const model::Model& model, const StationaryState& state) {
    return text("{}, {}", state.is_isotropic ? "isotropic" : "ordered", state_text(model, state.values));
}

}  // namespace drover::theory
