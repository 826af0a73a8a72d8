// dem/bodies/rotation.hpp: torque-free rotation of a body of revolution.
#pragma once
#include "drover/dem/vector.hpp"

namespace drover::dem {

/// Angular velocity [rad/s] of a body of revolution of axis n (length 1) and angular momentum L [mg mm^2/s]:
/// omega = L/I_across + (1/I_along - 1/I_across) (L.n) n.
Vector angular_velocity(const Vector& angular_momentum, const Vector& axis, double inertia_along,
                        double inertia_across);

/// Kinetic energy of rotation, omega.L/2 [mg mm^2/s^2].
double rotation_energy(const Vector& angular_momentum, const Vector& axis, double inertia_along, double inertia_across);

/// The axis after a time of free rotation, exact for any time: L is constant, and the axis precesses about it at
/// |L|/I_across.  (The rotation about the axis itself moves no sphere on it.)
Vector turned_freely(const Vector& axis, const Vector& angular_momentum, double inertia_across, double dt);

}  // namespace drover::dem
