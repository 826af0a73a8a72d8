// dem/packing/packing.hpp: shapes of the bodies that a setup asks for, and their initial positions and directions.
#pragma once
#include <cstdint>

#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// A rod of the supply with all its lengths scaled.
Shape rod_shape(const RodSupply& rods, double scale, const Locate& locate);

/// Mean projected area of a bead of the mixture [mm^2].
double mean_area(const BeadSupply& beads);

/// Bodies of the setup at rest between the plates at t = 0, without overlaps with each other, plates and walls.
/// Positions are random. Directions are random and without order (kind "random") or all along +x ("aligned").  Throws a
/// run Error with the remaining overlap if no packing was found (within about a minute at 70,000 beads), and an input
/// Error for impossible setups, such as more area than the cell has.
Bodies pack(const Setup& setup, std::uint64_t seed, const Locate& locate = no_location);

}  // namespace drover::dem
