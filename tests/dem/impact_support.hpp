// tests/dem/impact_support.hpp: bodies and contacts for tests of impacts.
#pragma once
#include "dem/impact/impact.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

inline const Shape the_rod =
    make_rod({1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 0.88, 0.88, 0.88, 0.72, 0.72, 0.72}, 4.5, 8.7);
inline const Shape the_bead = make_ball(0.8, 2.7);

inline ImpactBody impact_body(const Shape& shape, const Vector& axis = {1.0, 0.0, 0.0}) {
    return {.velocity = {},
            .spin = {},
            .axis = axis,
            .mass_inverse = 1.0 / shape.mass,
            .across_inverse = 1.0 / shape.inertia_across,
            .along_inverse = 1.0 / shape.inertia_along};
}

inline Vector momentum_angular(const ImpactBody& m) {
    const double along = dot(m.spin, m.axis);
    return 1.0 / m.across_inverse * (m.spin - along * m.axis) + along / m.along_inverse * m.axis;
}

/// A rod whose sphere k meets a plate below it.
inline Contact on_plate(const ImpactBody& m, std::size_t k, double e, double mu) {
    return {.first = 0,
            .second = -1,
            .normal = {0.0, 0.0, 1.0},
            .arm_first = the_rod.at[k] * m.axis - Vector{0.0, 0.0, the_rod.radius[k]},
            .arm_second = {},
            .wall_velocity = {},
            .restitution = e,
            .friction = mu,
            .impulse = {}};
}

}  // namespace drover::dem
