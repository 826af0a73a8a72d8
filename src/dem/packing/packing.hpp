// dem/packing/packing.hpp: initial positions and directions of bodies.
#pragma once
#include <cstdint>

#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// Bodies of the setup at rest between the plates at t = 0, without overlaps with each other, plates and walls.
/// Positions are random. Directions are random and without order (kind "random") or all along +x ("aligned").  Throws a
/// run Error with the remaining overlap if no packing was found (within about a minute at 70,000 beads), and an input
/// Error for impossible setups, such as more area than the cell has.
Bodies pack(const Setup& setup, std::uint64_t seed, const Locate& locate = no_location);

}  // namespace drover::dem
