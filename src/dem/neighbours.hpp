// dem/neighbours.hpp: which spheres may overlap before any has moved half a skin.
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

/// Pairs whose distance in the plane is less than their radii and a skin: heights never matter, since beads hop much
/// faster than they go left_skin. Of this wide list, a near one holds those within a part of the skin: it is gone
/// through in every step, and renewed often.
struct Neighbours {
    std::vector<SpherePair> pairs;
    std::vector<std::vector<SpherePair>> near;  ///< those of one chunk of `pairs` after another
    std::vector<ImagePair> images;              ///< pairs over an edge of a periodic cell
    std::vector<std::uint32_t> near_wall;       ///< spheres that may overlap a side wall
};

/// Of the near list; a sphere that has gone half of it makes it void [mm].
inline double near_skin(double skin) { return 0.2 * skin; }

/// Wraps bodies into a periodic cell, sorts the beads by place and makes both lists.  Throws a run Error that names a
/// body that is not at a finite place or has left the cell.
void make_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads);

/// A near list of the spheres as they stand, and a wide one before it when that is due.  Returns whether it was.
bool renew_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads);

/// Both lists as they were made before, from Spheres::listed and listed_wide.
void list_again(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads);

}  // namespace drover::dem
