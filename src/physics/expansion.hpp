// physics/expansion.hpp: the linearised equations at long waves, as a polynomial in q.
#pragma once
#include "drover/physics/equations.hpp"

namespace drover::physics {

/// The sum of the linearisations of the terms, forces not divided by m rho:
/// constant + i (q_x first_x + q_y first_y) + q_x^2 second_xx + q_y^2 second_yy + q_x q_y second_xy, up to second
/// order.
struct Expansion {
    Matrix6 constant, first_x, first_y, second_xx, second_yy, second_xy;
};

/// Throws as Equations::powers().
Expansion expansion(const Equations& equations, const UniformPoint& about);

}  // namespace drover::physics
