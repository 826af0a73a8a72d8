// tests/physics/uniform_points.hpp: uniform states of rods and beads by density, velocity and order, and what the
// general theory says of them.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/slow_order.hpp"
#include "physics/rod_bead_model.hpp"
#include "theory/limits.hpp"

namespace drover::physics {

using theory::LongWaves;
using theory::slow_growth;
using theory::slow_modes;
using theory::SlowMode;

/// A matrix between small deviations ~ exp(i q.r) of all fields from a uniform state, by FieldIndex.
using Symbol = Eigen::Matrix<std::complex<double>, FieldIndex::count, FieldIndex::count>;

/// A uniform state.
struct UniformPoint {
    double bead_density = 1.0, rod_density = 1.0;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero(), order = Eigen::Vector2d::Zero();
};
/// The direction from which wave angles are measured [rad]: that of the order; without order that of the bead velocity;
/// for an isotropic state the x axis.
inline double direction_of(const UniformPoint& point) {
    const Eigen::Vector2d& v = point.order.norm() > 0.0 ? point.order : point.velocity;
    return v.norm() > 0.0 ? std::atan2(v.y(), v.x()) : 0.0;
}

inline UniformPoint at_rest(const Densities& densities) {
    return {.bead_density = densities[0], .rod_density = densities[1]};
}

/// Of all components of right_sides().
inline model::UniformState values_of(const Equations& e, const UniformPoint& at) {
    const std::array<double, FieldIndex::count> values{at.bead_density, at.rod_density, at.velocity.x(),
                                                       at.velocity.y(), at.order.x(),   at.order.y()};
    model::UniformState state(static_cast<std::size_t>(e.right_sides().components()), 0.0);
    for (int k = 0; k < FieldIndex::count; ++k)
        if (const int place = component(e, k); place >= 0)
            state[static_cast<std::size_t>(place)] = values[static_cast<std::size_t>(k)];
    return state;
}
inline UniformPoint point_of(const Equations& e, const model::UniformState& values, const Densities& densities) {
    const auto value = [&](int field, double otherwise) {
        return component(e, field) < 0 ? otherwise : values[static_cast<std::size_t>(component(e, field))];
    };
    const auto second = [&](int field) {
        return component(e, field) < 0 ? 0.0 : values[static_cast<std::size_t>(component(e, field)) + 1];
    };
    return {.bead_density = value(FieldIndex::bead_density, densities[0]),
            .rod_density = value(FieldIndex::rod_density, densities[1]),
            .velocity = {value(FieldIndex::bead_velocity_x, 0.0), second(FieldIndex::bead_velocity_x)},
            .order = {value(FieldIndex::polar_order_x, 0.0), second(FieldIndex::polar_order_x)}};
}

struct StationaryState {
    std::string name;
    UniformPoint point;
    bool free_direction = false;
};
struct StationaryStates {
    std::vector<StationaryState> states;
    std::string no_order;
};

/// Those of model::stationary_states.
inline StationaryStates stationary_states(const Equations& e) {
    const Densities densities = mean_densities(e.model);
    const theory::StationaryStates found = theory::stationary_states(e.solver(densities));
    StationaryStates result{.states = {}, .no_order = found.why_no_order};
    for (const theory::StationaryState& state : found.states)
        result.states.push_back({.name = state.name,
                                 .point = point_of(e, state.values, densities),
                                 .free_direction = state.has_free_direction});
    return result;
}

/// The linearised equations about a uniform state, stationary or not; a slaved velocity is a field.
inline std::shared_ptr<const model::LinearisedAt> linearised(const Equations& e, const UniformPoint& about) {
    return std::make_shared<const model::LinearisedAt>(e.theory().linearised(values_of(e, about)));
}
inline LongWaves long_waves(const Equations& e, const StationaryState& about) {
    return theory::long_waves(*linearised(e, about.point));
}

using EffectiveCoefficients = calibrate::SlowOrder;
inline EffectiveCoefficients effective_coefficients(const Equations& e, double bead_density, double rod_density) {
    ModelValues model = e.model;
    number_in(model, "uniform.bead_density") = bead_density;
    number_in(model, "uniform.rod_density") = rod_density;
    return calibrate::slow_order(Equations(model));
}

}  // namespace drover::physics
