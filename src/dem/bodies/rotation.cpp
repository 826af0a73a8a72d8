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

}  // namespace drover::dem
