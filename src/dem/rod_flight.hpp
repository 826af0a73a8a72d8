// dem/rod_flight.hpp: a rod between base and lid: free flight from impact to impact.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "drover/dem/impact.hpp"
#include "drover/dem/world.hpp"
#include "plate_motion.hpp"

namespace drover::dem {

/// What a rod of one shape needs while it flies.
struct RodKind {
    Shape shape;
    std::vector<std::uint32_t> bearing;  ///< spheres that can touch a plate: those on the hull
    double restitution = 0.0, friction = 0.0;
};
RodKind make_rod_kind(const Shape& shape, double restitution, double friction);

/// What all rods share.
struct FlightRules {
    ImpactLaw law;
    double substep = 0.0;   ///< least time between impacts on the plates [s]
    double together = 0.0;  ///< gaps that act at once [mm]
    double kick = 0.0;      ///< [rad/mm]
    std::uint64_t seed = 0;
};

/// What a rod keeps of its impacts on the plates.
struct PlateMemory {
    std::int64_t hits = 0;      ///< since the start: the number of the next kick
    std::uint32_t signs = 0;    ///< of the kicks of this block of 32 hits
    double since_impact = 1.0;  ///< time from the last one [s]
};

/// A sphere of a rod over the base (side +1) or under the lid (-1): its gap and how it changes.
struct PlateGap {
    std::uint32_t sphere;
    double side, gap, speed, push;
};

/// Room for the gaps and contacts of one rod, used again for the next.
struct FlightSpace {
    std::vector<PlateGap> gaps;
    std::vector<Contact> contacts;
    std::vector<double> approach;
};

/// Moves a rod by dt under a uniform acceleration, with all its impacts on base and lid.  `plates` stand at the start.
void fly(Rod& rod, PlateMemory& memory, std::uint64_t number, const RodKind& kind, const Vector& acceleration,
         const PlateMotion& plates, double dt, const FlightRules& rules, FlightSpace& space, EnergyBalance& balance,
         Counts& counts);

/// The rod as an impact sees it, and its momentum after one.
Mover mover_of(const Rod& rod, const Shape& shape);
Vector angular_momentum(const Mover& mover);

}  // namespace drover::dem
