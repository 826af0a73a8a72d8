// physics/point_arrays.hpp: which arrays the active terms of a model need at the points of the grid, and which they make.
#pragma once
#include "drover/physics/model.hpp"

namespace drover::physics {

/// Places of what is brought to the grid and from it, -1 when it is not; a vector has two.
struct Arrays {
    int beads = -1, rods = -1, velocity = -1, order = -1, force = -1, velocity_curl = -1, order_curl = -1, back = 0;
    int bead_flux = -1, rod_flux = -1, velocity_rate = -1, order_rate = -1, velocity_head = -1, order_head = -1,
        forth = 0;
};
Arrays arrays_of(const Equations& equations);

/// The densities that a coefficient depends on, as inputs of a term.
unsigned reads_of(const Coefficient& coefficient);

/// A slaved velocity whose drag or driving depends on the densities: it is no linear function of the fields.
bool slaved_varies(const Equations& equations);

}  // namespace drover::physics
