// dem/impact.hpp: what impulses bodies that touch and approach give each other: restitution and Coulomb friction in groups of contacts.
#pragma once
#include <cstddef>
#include <span>

#include "drover/dem/vector.hpp"

namespace drover::dem {

struct ContactControl;

/// A body of revolution as an impact sees it.
struct ImpactBody {
    Vector velocity;              ///< of its centre of mass [mm/s]
    Vector spin;                  ///< angular velocity [rad/s]
    Vector axis;                  ///< of length 1; any for a sphere
    double mass_inverse = 0.0;    ///< [1/mg]
    double across_inverse = 0.0;  ///< 1/inertia about an axis across its own [1/(mg mm^2)]
    double along_inverse = 0.0;   ///< the same about its own
};

/// A contact of two bodies, or of one with a wall that moves as it is told.
struct Contact {
    int first = 0, second = -1;    ///< bodies; second = -1: a wall
    Vector normal;                 ///< of length 1, towards `first`
    Vector arm_first, arm_second;  ///< from the centres of mass to the place of contact [mm]
    Vector wall_velocity;          ///< at that place [mm/s]
    double restitution = 0.0;      ///< e, 0 to 1
    double friction = 0.0;         ///< mu >= 0
    Vector impulse;                ///< result: on `first` [mg mm/s]
};

/// How the impulses of a group are found.
enum class GroupLaw {
    simultaneous,       ///< all contacts are pressed together, see resolve()
    approaching_first,  ///< one impact after another: that which approaches fastest comes next
    first_to_last,      ///< one after another, as they stand, again and again
    last_to_first
};

/// What ends the impact of one contact.
enum class RestitutionKind {
    energetic,  ///< Stronge: the normal force gives back e^2 of the work that it took
    kinetic,    ///< Poisson: the impulse of restitution is e times that of compression
    kinematic   ///< Newton: the normal velocity after is -e times that before
};

struct ImpactLaw {
    static constexpr const char* name = "impulse";  ///< of contacts.model
    static ImpactLaw from(const ContactControl& control);

    GroupLaw group = GroupLaw::simultaneous;
    RestitutionKind restitution =
        RestitutionKind::energetic;  ///< of the laws that take one contact after another, and of single contacts
    bool track_slip = true;          ///< friction opposes the slip of each moment of the impact; false: that before it
    int increments = 8;              ///< of an impact during which the slip turns
    double inelastic_threshold =
        0.03;  ///< approaches below this times 1 - e, beside the largest before, end without rebound; 0: none
    double tolerance = 1e-2;  ///< speed of approach that may be left, beside the largest before
};

/// What a group of impacts did, as energies [mg mm^2/s^2]: the kinetic energy of the bodies changed by walls + normal + friction.
struct ImpactOutcome {
    double walls = 0.0;  ///< work of the walls' own motion
    double normal =
        0.0;  ///< work of the normal impulses on the relative motion: <= 0 unless the restitution is not energetic
    double friction = 0.0;  ///< work of friction on the relative motion: <= 0 where the slip is tracked
    double residual = 0.0;  ///< largest speed of approach left [mm/s]
    double approach = 0.0;  ///< largest speed of approach before [mm/s]
    int sweeps = 0;         ///< over the contacts
};

/// Velocity of `first` past `second` at the place of contact [mm/s].
Vector relative_velocity(const Contact& contact, std::span<const ImpactBody> bodies);

/// Kinetic energy of a impact_body [mg mm^2/s^2].
double energy_kinetic(const ImpactBody& impact_body);

/// Finds the impulses of contacts that share bodies, some of which approach, and changes the velocities of the bodies.
///
/// A single contact: the impact is followed in small increments of the normal impulse (Darboux and Keller), in each of which friction takes
/// the most energy that a tangential impulse of mu times the normal one can; it sticks, turns and reverses as the slip does.
/// Several (`simultaneous`): every contact is a spring of one stiffness while it is pressed and of 1/e^2 times that while it gives back, so
/// that it gives back e^2 of the work it took, and all move together (Liu, Zhao & Brogliato, Proc. R. Soc. A 464, 3193 (2008), with all
/// stiffnesses alike); the places stay where they are, so that the unit of stiffness does not matter.  In each small moment contacts are
/// taken one after another, once from the first to the last and once the other way round, and the mean of both ends is the result: the order of
/// two contacts does not matter at all, that of more at the second order of a moment alone.
/// Every impulse does its work on the mean of the velocities before and after it, so that energies add up to rounding, and with energetic
/// restitution and tracked slip no contact gives more than it took: no group gains energy from anything but moving walls.
/// Sources: Stronge, Impact Mechanics (2000), ch. 3 to 5; Keller, J. Appl. Mech. 53, 1 (1986).
ImpactOutcome resolve(std::span<ImpactBody> bodies, std::span<Contact> contacts, const ImpactLaw& law);

}  // namespace drover::dem
