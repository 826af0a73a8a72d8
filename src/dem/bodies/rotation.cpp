// dem/bodies/rotation.cpp: the free symmetric top.
#include "dem/bodies/rotation.hpp"

namespace drover::dem {

Vector angular_velocity(const Vector& angular_momentum, const Vector& axis, double inertia_along,
                        double inertia_across) {
    const double spin = dot(angular_momentum, axis);
    return 1.0 / inertia_across * angular_momentum + (1.0 / inertia_along - 1.0 / inertia_across) * spin * axis;
}

double rotation_energy(const Vector& angular_momentum, const Vector& axis, double inertia_along,
                       double inertia_across) {
    return 0.5 * dot(angular_momentum, angular_velocity(angular_momentum, axis, inertia_along, inertia_across));
}

Vector turned_freely(const Vector& axis, const Vector& angular_momentum, double inertia_across, double dt) {
    const double size = length(angular_momentum);
    if (size == 0.0) return axis;
    const double angle = size * dt / inertia_across;
    // Below 0.02 the series is exact to the last bit and ten times faster; rotations in a step are small.
    const auto sine_of = [](double x) {
        const double square = x * x;
        return square < 4e-4 ? x * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))) : std::sin(x);
    };
    const double sine = sine_of(angle), half = sine_of(0.5 * angle);
    const Vector pole = 1.0 / size * angular_momentum, round = cross(pole, axis);
    // Rodrigues: n + sin(angle) (pole x n) + (1 - cos(angle)) pole x (pole x n), the last factor without cancellation.
    const Vector turned = axis + sine * round + 2.0 * half * half * cross(pole, round);
    return 1.0 / length(turned) * turned;
}

}  // namespace drover::dem
