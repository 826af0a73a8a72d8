// dem/bead_flight.hpp: beads between base and lid: free flight from impact to impact.
#pragma once
#include <cstddef>

#include "drover/dem/world.hpp"
#include "plate_motion.hpp"
#include "spheres.hpp"

namespace drover::dem {

struct BeadRules {
    Vector acceleration;  ///< of gravity [mm/s^2]
    Vector force;         ///< on each bead [mg mm/s^2]
    double restitution = 0.0, friction = 0.0;
    double skin = 0.0;  ///< [mm]
};

/// Moves the beads [begin, end) by dt with all their impacts on the plates, which stand at the start.  Returns whether one has gone half a skin
/// from where it was listed (or no_location at all).
bool fly_beads(Spheres& spheres, std::size_t begin, std::size_t end, const PlateMotion& plates, double dt,
               const BeadRules& rules, EnergyBalance& balance, Counts& counts);

}  // namespace drover::dem
