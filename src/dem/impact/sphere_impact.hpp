// dem/impact/sphere_impact.hpp: the closed form of the impact of a sphere with another sphere, a plate or a wall.
#pragma once
#include <algorithm>

namespace drover::dem {

/// A reduced mass m = numerator/denominator [mg].  Callers have either m or 1/m; the division is left to the law.
struct ReducedMass {
    double numerator = 1.0, denominator = 1.0;
};

/// Impulses on the first body: `normal` along the normal, `tangential` against the slip.
struct SphereImpact {
    double normal = 0.0, tangential = 0.0;  ///< [mg mm/s], both >= 0
    double friction_work = 0.0;             ///< <= 0 [mg mm^2/s^2]
};

/// Restitution e and Coulomb friction mu.  A sphere's normal impulse does not change its slip, and friction does not
/// turn the slip, so the impact has a closed form: P_n = (1 + e) m |u_n|, P_t = min(mu P_n, |u_t|/w_t). opening_speed:
/// u_n < 0.  slip: |u_t| >= 0 at the point of contact.  slip_response: w_t, change of slip per tangential impulse
/// [1/mg].
inline SphereImpact sphere_impact(double opening_speed, double slip, const ReducedMass& mass, double slip_response,
                                  double restitution, double friction) {
    const double normal = -(1.0 + restitution) * opening_speed * mass.numerator / mass.denominator;
    const double tangential = std::min(friction * normal, slip / slip_response);
    return {.normal = normal,
            .tangential = tangential,
            .friction_work = -tangential * (slip - 0.5 * slip_response * tangential)};
}

}  // namespace drover::dem
