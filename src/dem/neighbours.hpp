// dem/neighbours.hpp: which spheres may touch before any has moved half a skin.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/base/threads.hpp"
#include "spheres.hpp"

namespace drover::dem {

struct SpherePair {
    std::uint32_t first = 0, second = 0;
};
struct ImagePair {
    std::uint32_t first = 0, second = 0;
    double x = 0.0, y = 0.0;  ///< added to the place of `second` [mm]
};

/// Pairs whose distance in the plane is less than their radii and a skin: heights never matter, since beads hop much faster than they go astray.
struct Neighbours {
    std::vector<SpherePair> pairs;
    std::vector<ImagePair> images;         ///< pairs over an edge of a periodic cell
    std::vector<std::uint32_t> near_wall;  ///< spheres that may touch a side wall
};

/// Wraps bodies into a periodic cell, sorts the beads by place and lists the pairs.  Throws a run Error that names a body that is not at a finite
/// place or has left the cell.
void make_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours);

/// Lists the pairs of spheres as they were listed before, from Spheres::listed.
void list_again(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours);

}  // namespace drover::dem
