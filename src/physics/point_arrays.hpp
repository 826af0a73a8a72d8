// physics/point_arrays.hpp: which arrays the active terms of a model need at the points of the grid, and which they
// make.
#pragma once
#include <array>

#include "drover/physics/equations.hpp"

namespace drover::physics {

/// Indices of the arrays transformed to and from the grid, -1 if not transformed; vectors occupy two.
struct Arrays {
    std::array<int, Input::count> in{};
    int linear_force = -1, inverse = 0;  ///< inverse: arrays transformed to the grid
    std::array<int, Output::count> out{};
    int forward = 0;  ///< arrays transformed from the grid

    int of(Input::Value input) const { return in[static_cast<std::size_t>(input)]; }
    int of(Output::Value output) const { return out[static_cast<std::size_t>(output)]; }
};
Arrays arrays_of(const Equations& equations);

}  // namespace drover::physics
