// dem/flight/rod_flight.hpp: a rod between base and lid: free flight from impact to impact.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/flight/step_rules.hpp"
#include "drover/dem/bodies.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

/// Constants of all rods of one shape.
struct RodKind {
    Shape shape;
    std::vector<std::uint32_t> bearing;  ///< spheres that can touch a plate, from tail to head
    std::vector<Vec4d> at, radius;       ///< the same of `bearing`, four by four; beyond the last: 0 and -infinity
    double restitution = 0.0, friction = 0.0;
};
/// The bearing spheres are all, or those on the convex hull (rods.bearing).  In exact contact no other sphere can touch
/// a plate; in a time-driven law a rod overlaps the plate, and then several of the spheres between those on the hull
/// do.
RodKind make_rod_kind(const Shape& shape, double restitution, double friction, bool all_bear);

/// State of a rod that comes from its impacts on the plates.
struct PlateMemory {
    std::int64_t hits = 0;      ///< the number of the next kick
    std::uint32_t signs = 0;    ///< of the kicks of this block of 32 hits
    double since_impact = 1.0;  ///< time since the last impact [s]
};

/// Gap of a sphere over the base (side +1) or under the lid (-1), with its first and second derivative in time.
struct PlateGap {
    std::uint32_t sphere;
    double side, gap, speed, acceleration;
};

/// An overlap of a rod with base (side +1) or lid (-1).
struct RodPlateOverlap {
    std::uint32_t sphere;  ///< of the rod, from the tail
    double side, depth;    ///< depth [mm] > 0
};

/// The contact of a sphere of a rod with base (side +1) or lid (-1).
inline Contact plate_contact(const Rod& rod, const RodKind& kind, std::uint32_t sphere, double side,
                             const PlateState& base) {
    const Vector normal{0.0, 0.0, side};
    return {.normal = normal,
            .arm_first = kind.shape.at[sphere] * rod.axis - kind.shape.radius[sphere] * normal,
            .wall_velocity = {0.0, 0.0, base.velocity},
            .restitution = kind.restitution,
            .friction = kind.friction};
}

/// Scratch memory, reused from rod to rod.
struct FlightSpace {
    std::vector<PlateGap> gaps;
    std::vector<RodPlateOverlap> overlaps;
    std::vector<Contact> contacts;
    std::vector<char> overlapped;  ///< by gap: its overlap was removed
    std::vector<double> approach;
};

/// Moves a rod by rules.dt under a uniform acceleration, with all its impacts on base and lid.  `plates` are at the
/// start of the step.
void fly_rod(Rod& rod, PlateMemory& memory, std::uint64_t number, const RodKind& kind, const Vector& acceleration,
             const PlateMotion& plates, const StepRules& rules, FlightSpace& space, EnergyBalance& balance,
             Counts& counts);

/// Free motion under a uniform acceleration.
void drift_rod(Rod& rod, const Shape& shape, const Vector& acceleration, double tau, EnergyBalance& balance);

/// omega_z += size or -size, with equal probability.
void kick_spin(ImpactBody& rod, double size, PlateMemory& memory, std::uint64_t number, std::uint64_t seed,
               EnergyBalance& balance);

/// The rod as the impact laws see it, and its angular momentum after an impact.
ImpactBody impact_body_of(const Rod& rod, const Shape& shape);
Vector angular_momentum(const ImpactBody& body);

}  // namespace drover::dem
