// physics/symbol.hpp: uniform states of rods and beads, and linearisations about them.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <complex>

#include "drover/physics/model.hpp"

namespace drover::physics {

/// The fields as rows and columns of a Symbol, for every form.
struct FieldIndex {
    enum Value : int {
        bead_density,
        rod_density,
        bead_velocity_x,
        bead_velocity_y,
        polar_order_x,
        polar_order_y,
        count
    };
};

/// A matrix between small deviations ~ exp(i q.r) of all fields from a uniform state.
using Symbol = Eigen::Matrix<std::complex<double>, FieldIndex::count, FieldIndex::count>;

/// The uniform state about which the exact linear part is taken: its densities, the beads at rest, no order.
struct Reference {
    double bead_density = 1.0, rod_density = 1.0;
};
inline Reference reference(const UniformState& uniform) {
    return {.bead_density = uniform.bead_density, .rod_density = uniform.rod_density};
}

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
inline UniformPoint at_rest(const Reference& densities) {
    return {.bead_density = densities.bead_density, .rod_density = densities.rod_density};
}

}  // namespace drover::physics
