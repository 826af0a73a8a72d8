// dem/spheres.hpp: the bodies of a world in the layout that its step works on.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "rod_flight.hpp"
#include "vec4d.hpp"

namespace drover::dem {

/// Beads, sorted by place whenever a neighbour list is made.  Slot s holds bead number[s] of the caller's list.
struct BeadArrays {
    std::vector<Vec4d> velocity;  ///< x, y, z and 1/mass
    std::vector<Vec4d> spin;      ///< x, y, z and 1/inertia
    std::vector<std::uint32_t> number, shape;
    std::vector<std::array<std::int32_t, 2>> image;  ///< cells that it has been moved back by

    std::size_t size() const { return velocity.size(); }
};

struct RodArrays {
    std::vector<Rod> rod;  ///< in the caller's order; positions wrapped
    std::vector<PlateMemory> memory;
    std::vector<std::uint32_t> kind;   ///< of kinds
    std::vector<std::uint32_t> first;  ///< sphere of each, and one past the last
    std::vector<std::uint32_t> owner;  ///< rod of each rod sphere
    std::vector<std::array<std::int32_t, 2>> image;
    std::vector<RodKind> kinds;

    std::size_t size() const { return rod.size(); }
};

/// All spheres: those of beads first, then those of rods, rod after rod.
struct Spheres {
    std::vector<Vec4d> position;                     ///< x, y, z and radius
    std::vector<std::array<double, 2>> listed;       ///< x, y when the near list of neighbours was made
    std::vector<std::array<double, 2>> listed_wide;  ///< when the wide one was
    BeadArrays beads;
    RodArrays rods;

    std::size_t size() const { return position.size(); }
    bool is_bead(std::uint32_t sphere) const { return sphere < beads.size(); }
    /// The rod of a sphere that is not a bead.
    std::uint32_t rod(std::uint32_t sphere) const { return rods.owner[sphere - beads.size()]; }
    /// Bodies are numbered like their first: beads by slot, then rods.
    std::uint32_t body(std::uint32_t sphere) const {
        return is_bead(sphere) ? sphere : static_cast<std::uint32_t>(beads.size()) + rod(sphere);
    }
    const Shape& shape_of_rod(std::size_t r) const { return rods.kinds[rods.kind[r]].shape; }
};

/// Whether a sphere has gone as far from where it was listed as `square` says, or no_location at all.
inline bool has_left_skin(const Vec4d& place, const std::array<double, 2>& listed, double square) {
    const double x = place[0] - listed[0], y = place[1] - listed[1];
    return !(x * x + y * y < square);
}

/// Puts the spheres of a rod where the rod is.
inline void set_rod_spheres(Spheres& spheres, std::size_t r) {
    const Rod& rod = spheres.rods.rod[r];
    const Shape& shape = spheres.shape_of_rod(r);
    for (std::size_t k = 0; k < shape.at.size(); ++k) {
        Vec4d& position = spheres.position[spheres.rods.first[r] + k];
        set_vector(position, rod.position + shape.at[k] * rod.axis);
    }
}

}  // namespace drover::dem
