// dem/neighbours/neighbours.hpp: lists of spheres that may come to overlap before any has moved by half a skin, and the
// search in them for spheres that overlap each other or a side wall.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/bodies/walls.hpp"
#include "dem/flight/spheres.hpp"
#include "drover/base/threads.hpp"

namespace drover::dem {

struct SpherePair {
    std::uint32_t first = 0, second = 0;
};
struct ImagePair {
    std::uint32_t first = 0, second = 0;
    double x = 0.0, y = 0.0;  ///< added to the position of `second` [mm]
};

/// Pairs whose distance in the plane is less than their radii plus a skin.  Heights are ignored: beads bounce much
/// faster than they move sideways.  A second, near list holds the pairs within a fraction of the skin; it is walked in
/// every step and renewed often.
struct Neighbours {
    std::vector<SpherePair> pairs;
    std::vector<std::vector<SpherePair>> near;  ///< by chunk of `pairs`
    std::vector<ImagePair> images;              ///< pairs over an edge of a periodic cell
    std::vector<std::uint32_t> near_wall;       ///< spheres that may come to overlap a side wall
};

/// Skin of the near list [mm]; the list is invalid once a sphere has moved by half of it.
inline double near_skin(double skin) { return 0.2 * skin; }

/// Wraps bodies into a periodic cell, sorts the beads by position and makes both lists.  Throws a run Error that names
/// a body without a finite position or far from the cell.
void make_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads);

/// Makes the near list of the present positions, and first the wide list if it is invalid.  Returns whether it was.
bool renew_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads);

/// Makes both lists again from Spheres::listed and listed_wide.
void list_again(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads);

/// Two spheres that overlap, or a sphere and a surface.
struct Overlap {
    /// Values of `second` for surfaces.
    static constexpr std::uint32_t side_wall = 0xffffffffu, lid = 0xfffffffeu, base = 0xfffffffdu;

    std::uint32_t first = 0, second = side_wall;  ///< indices of spheres, or a surface
    std::uint32_t first_body = 0, second_body = side_wall;
    Vector apart;        ///< from second (or the surface) to the centre of first [mm]
    double reach = 0.0;  ///< distance at which they overlap [mm]
    double since = 0.0;  ///< time since they touched [s]
    Vector normal;       ///< towards first at the time of first contact

    bool is_with_surface() const { return second >= base; }
};

/// Of the two spheres, or of the sphere that overlaps a surface [mm].
double smaller_radius(const Overlap& overlap, const Spheres& spheres);

/// Depth of the overlap relative to the smaller radius.
double relative_depth(const Overlap& overlap, const Spheres& spheres);

/// Reuses its memory from step to step.
class OverlapSearch {
public:
    /// All overlaps of spheres with each other and with the side walls.  Their order does not depend on the number of
    /// threads.
    std::vector<Overlap>& find(const Walls& walls, const Spheres& spheres, const Neighbours& neighbours,
                               Threads& threads);

private:
    std::vector<Overlap> overlaps_;
    std::vector<std::vector<Overlap>> found_;  // by chunk of the near list
};

}  // namespace drover::dem
