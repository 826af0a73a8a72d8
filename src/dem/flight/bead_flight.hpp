// dem/flight/bead_flight.hpp: beads between base and lid: free flight from impact to impact.
#pragma once
#include <cstddef>

#include "dem/bodies/plate_motion.hpp"
#include "dem/flight/spheres.hpp"
#include "dem/flight/step_rules.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

/// The impact of a bead on the base (side +1) or the lid (-1), which moves at the speed `plate`.
void bounce_on_plate(Vec4d& velocity, Vec4d& spin, double radius, double side, double plate, double restitution,
                     double friction, EnergyBalance& balance);

/// Moves the beads [begin, end) by rules.dt with all their impacts on the plates.  `plates` are at the start of the
/// step.  Returns whether a bead has moved by half a skin since the neighbour list was made, or has no finite position.
bool fly_beads(Spheres& spheres, std::size_t begin, std::size_t end, const PlateMotion& plates, const StepRules& rules,
               EnergyBalance& balance, Counts& counts);

/// The same without plates: uniformly accelerated motion.
bool drift_beads(Spheres& spheres, std::size_t begin, std::size_t end, const StepRules& rules);

}  // namespace drover::dem
