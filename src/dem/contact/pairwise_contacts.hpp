// dem/contact/pairwise_contacts.hpp: the contacts of the pairwise law: beads and rods on the plates, pairs and side
// walls.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/bodies/plate_motion.hpp"
#include "dem/contact/contact_law.hpp"
#include "dem/contact/contact_report.hpp"
#include "dem/flight/bead_flight.hpp"
#include "dem/flight/rod_flight.hpp"

namespace drover::dem {

/// Moves the beads [begin, end) by rules.dt, to the end of a step whose base is `base`, and resolves their contacts
/// with the plates.  Returns whether a bead has moved by half a skin since the neighbour list was made, or has no
/// finite position.
bool step_beads(Spheres& spheres, std::size_t begin, std::size_t end, const PlateState& base, const PlateMotion& plates,
                const StepRules& rules, ContactReport& report);

/// Moves rod `number` by rules.dt in steps of at most rod_step, with its contacts with the plates after each.  `plates`
/// are at the start of time step `step`.
void step_rod(Spheres& spheres, std::size_t number, const Vector& acceleration, const PlateMotion& plates,
              std::int64_t step, const PairwiseLaw& law, const StepRules& rules, std::vector<RodPlateOverlap>& scratch,
              ContactReport& report);

/// The contacts of pairs and with the side walls, in this order or backwards.
ContactReport resolve_pairs(const std::vector<Overlap>& overlaps, Spheres& spheres, const PairwiseLaw& law,
                            const StepRules& rules, bool backwards);

}  // namespace drover::dem
