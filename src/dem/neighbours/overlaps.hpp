// dem/neighbours/overlaps.hpp: search for spheres that overlap each other or a side wall.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/bodies/walls.hpp"
#include "dem/flight/spheres.hpp"
#include "dem/neighbours/neighbours.hpp"
#include "drover/base/threads.hpp"

namespace drover::dem {

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
