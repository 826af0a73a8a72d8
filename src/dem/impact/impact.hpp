// dem/impact/impact.hpp: impulses between rigid bodies in contact: restitution and Coulomb friction, in groups of
// contacts, and in closed form of a sphere with another sphere, a plate or a wall.
#pragma once
#include <algorithm>
#include <span>

#include "drover/dem/bodies.hpp"
#include "drover/dem/setup.hpp"

namespace drover::dem {

/// A body of revolution, as the impact laws see it.
struct ImpactBody {
    Vector velocity;              ///< of its centre of mass [mm/s]
    Vector spin;                  ///< angular velocity [rad/s]
    Vector axis;                  ///< of length 1; any for a sphere
    double mass_inverse = 0.0;    ///< [1/mg]
    double across_inverse = 0.0;  ///< 1/inertia about an axis perpendicular to its own [1/(mg mm^2)]
    double along_inverse = 0.0;   ///< 1/inertia about its own axis
};

/// A contact of two bodies, or of a body and a wall with a prescribed motion.
struct Contact {
    int first = 0, second = -1;    ///< indices of bodies; second = -1: a wall
    Vector normal;                 ///< of length 1, towards `first`
    Vector arm_first, arm_second;  ///< from the centres of mass to the point of contact [mm]
    Vector wall_velocity;          ///< at the point of contact [mm/s]
    double restitution = 0.0;      ///< e, 0 to 1
    double friction = 0.0;         ///< mu >= 0
    Vector impulse;                ///< result: on `first` [mg mm/s]
};

struct ImpactLaw {
    /// Allowed error of the relative velocity by one increment of the impact of a single contact, relative to its
    /// approach.  The whole impact has ten or so that count, each with a third of that error or less.
    static constexpr double increment_error = 1e-4;
    static ImpactLaw from(const ContactControl& control);

    GroupLaw group = GroupLaw::simultaneous;
    RestitutionKind restitution = RestitutionKind::energetic;  ///< `simultaneous` groups are always energetic
    bool track_slip = true;  ///< friction opposes the slip at each moment of the impact; false: the slip before it
    int increments = 8;      ///< of the impact of a group; those of a single contact follow their error
    double inelastic_threshold =
        0.03;                 ///< approaches below this times 1 - e of the largest end without rebound; 0: none
    double tolerance = 1e-2;  ///< allowed remaining speed of approach, relative to the largest before
};

/// Effects of the impacts of a group, as energies [mg mm^2/s^2]: the kinetic energy changes by walls + normal +
/// friction.
struct ImpactOutcome {
    double walls = 0.0;     ///< work of the motion of the walls
    double normal = 0.0;    ///< work of the normal impulses on the relative motion: <= 0 with energetic restitution
    double friction = 0.0;  ///< work of friction on the relative motion: <= 0 where the slip is tracked
    double residual = 0.0;  ///< largest remaining speed of approach [mm/s]
    double approach = 0.0;  ///< largest speed of approach before [mm/s]
    double left = 0.0;      ///< speed of approach that the law of a group left [mm/s]: if above the tolerance, it was
                            ///< ended without rebound or friction
    int sweeps = 0;         ///< over the contacts
    int increments = 0;     ///< evaluated for a single contact
};

/// Velocity of `first` relative to `second` at the point of contact [mm/s].
Vector relative_velocity(const Contact& contact, std::span<const ImpactBody> bodies);

/// Kinetic energy of a body [mg mm^2/s^2].
double energy_kinetic(const ImpactBody& body);

/// Finds the impulses of contacts that share bodies, some of which approach, and changes the velocities of the bodies.
///
/// A single contact: the impact is followed in increments of the normal impulse (Darboux and Keller), which are halved
/// until their error is below increment_error.  In each, friction opposes the slip in its middle; where the slip stops,
/// the contact sticks if friction can hold it, and slides on otherwise. Several contacts (`simultaneous`): every
/// contact is a spring of one stiffness in compression and of 1/e^2 times that in restitution, so it gives back e^2 of
/// its work, and all springs
/// act at the same time (Liu, Zhao & Brogliato, Proc. R. Soc. A 464, 3193 (2008), with equal stiffnesses).  Positions
/// do not change, so the unit of stiffness does not matter.  Contacts advance one after another within each small time,
/// once in ascending and once in descending order, and the result is the mean of both: exactly independent of the order
/// of two contacts, and to second order in the increment for more. Every impulse works on the mean of the velocities
/// before and after it, so energies add up to rounding.  With energetic restitution and tracked slip no contact gives
/// back more than it took: no group gains energy except from moving walls.
///
/// A law may leave an approach: friction can hold a body between contacts whose springs would push it to and fro for
/// ever, and impacts in turn may need too many turns.  The rest then ends without rebound or friction, by the impulses
/// that leave the least energy. Sources: Stronge, Impact Mechanics (2000), ch. 3 to 5; Keller, J. Appl. Mech. 53, 1
/// (1986).
ImpactOutcome resolve(std::span<ImpactBody> bodies, std::span<Contact> contacts, const ImpactLaw& law);

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
