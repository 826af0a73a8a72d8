// dem/packing.hpp: where bodies are at the start.
#pragma once
#include <cstdint>

#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// A packing and how it was reached.
struct Packed {
    Bodies bodies;
    double overlap = 0.0;  ///< largest, beside the smaller radius of the pair: none in a packing
    int rounds = 0;        ///< of pushing bodies apart that it took
};

/// Bodies of the setup at rest between the plates at t = 0, without overlaps (with each other, plates and walls), at random places and, for
/// kind "random", in random directions without order; "aligned": all rods along +x.  Throws a run Error, with how far it came, when no packing
/// was found within the rounds it takes (a minute at the paper's size), and an input Error for what cannot be: more area than the cell has.
Packed pack(const Setup& setup, std::uint64_t seed, const LocationOf& place = no_location);

}  // namespace drover::dem
