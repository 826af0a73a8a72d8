// dem/bodies/rotation.hpp: torque-free rotation of a body of revolution.
#pragma once
#include <cmath>

#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// Angular velocity [rad/s] of a body of revolution of axis n (length 1) and angular momentum L [mg mm^2/s]:
/// omega = L/I_across + (1/I_along - 1/I_across) (L.n) n.
inline Vector angular_velocity(const Rod& rod, const Shape& shape) {
    const double spin = dot(rod.angular_momentum, rod.axis);
    return 1.0 / shape.inertia_across * rod.angular_momentum +
           (1.0 / shape.inertia_along - 1.0 / shape.inertia_across) * spin * rod.axis;
}

/// Kinetic energy of rotation, omega.L/2 [mg mm^2/s^2].
inline double rotation_energy(const Rod& rod, const Shape& shape) {
    return 0.5 * dot(rod.angular_momentum, angular_velocity(rod, shape));
}

/// The axis after a time of free rotation, exact for any time: L is constant, and the axis precesses about it at
/// |L|/I_across.  (The rotation about the axis itself moves no sphere on it.)
inline Vector turned_freely(const Vector& axis, const Vector& angular_momentum, double inertia_across, double dt) {
    const Vector turn = dt / inertia_across * angular_momentum, round = cross(turn, axis), inward = cross(turn, round);
    const double square = dot(turn, turn);
    // Rodrigues: n + sin(angle)/angle (turn x n) + (1 - cos(angle))/angle^2 turn x (turn x n).  Below an angle of 0.02
    // both series are exact to the last bit and ten times faster; rotations in a step are small.
    double sine = 1.0 - square * (1.0 / 6.0) * (1.0 - square * (1.0 / 20.0) * (1.0 - square * (1.0 / 42.0)));
    double cosine = 0.5 - square * (1.0 / 24.0) * (1.0 - square * (1.0 / 30.0) * (1.0 - square * (1.0 / 56.0)));
    if (square > 4e-4) [[unlikely]] {
        const double angle = std::sqrt(square), half = std::sin(0.5 * angle) / angle;
        sine = std::sin(angle) / angle;
        cosine = 2.0 * half * half;  // without cancellation
    }
    const Vector turned = axis + sine * round + cosine * inward;
    const double excess = dot(turned, turned) - 1.0;
    // The series of 1/length is exact to the last bit, too, where only rounding has changed the length.
    return (std::abs(excess) < 1e-8 ? 1.0 - 0.5 * excess : 1.0 / std::sqrt(1.0 + excess)) * turned;
}

}  // namespace drover::dem
