// dem/flight/spheres.hpp: the bodies of a world in the memory layout of its step.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "dem/bodies/vec4d.hpp"
#include "dem/flight/rod_flight.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// Beads, sorted by position when a neighbour list is made.  Slot s has bead number[s] of the caller's list.
struct BeadArrays {
    std::vector<Vec4d> velocity;  ///< x, y, z and 1/mass
    std::vector<Vec4d> spin;      ///< x, y, z and 1/inertia
    std::vector<std::uint32_t> number, shape;
    std::vector<std::array<std::int32_t, 2>> image;  ///< periods that wrapping has subtracted

    std::size_t size() const { return velocity.size(); }
};

struct RodArrays {
    std::vector<Rod> rod;  ///< in the caller's order; positions wrapped
    std::vector<PlateMemory> memory;
    std::vector<std::uint32_t> kind;   ///< of kinds
    std::vector<std::uint32_t> first;  ///< first sphere of each rod, and one past the last sphere
    std::vector<std::uint32_t> owner;  ///< rod of each rod sphere
    std::vector<std::array<std::int32_t, 2>> image;
    std::vector<RodKind> kinds;

    std::size_t size() const { return rod.size(); }
};

/// All spheres: beads first, then rods in their order.
struct Spheres {
    std::vector<Vec4d> position;                     ///< x, y, z and radius
    std::vector<std::array<double, 2>> listed;       ///< x, y when the near list was made
    std::vector<std::array<double, 2>> listed_wide;  ///< x, y when the wide list was made
    BeadArrays beads;
    RodArrays rods;

    std::size_t size() const { return position.size(); }
    bool is_bead(std::uint32_t sphere) const { return sphere < beads.size(); }
    /// The rod of a sphere that is not a bead.
    std::uint32_t rod(std::uint32_t sphere) const { return rods.owner[sphere - beads.size()]; }
    /// Bodies are numbered beads first, by slot, then rods.
    std::uint32_t body(std::uint32_t sphere) const {
        return is_bead(sphere) ? sphere : static_cast<std::uint32_t>(beads.size()) + rod(sphere);
    }
    const Shape& shape_of_rod(std::size_t r) const { return rods.kinds[rods.kind[r]].shape; }
};

/// Whether a sphere has moved by the root of `square` since it was listed, or has no finite position.
inline bool has_left_skin(const Vec4d& position, const std::array<double, 2>& listed, double square) {
    const double x = position[0] - listed[0], y = position[1] - listed[1];
    return !(x * x + y * y < square);
}

/// Sets the spheres of a rod from its position and axis.
inline void set_rod_spheres(Spheres& spheres, std::size_t r) {
    const Rod& rod = spheres.rods.rod[r];
    const Shape& shape = spheres.shape_of_rod(r);
    for (std::size_t k = 0; k < shape.at.size(); ++k) {
        Vec4d& position = spheres.position[spheres.rods.first[r] + k];
        set_vector(position, rod.position + shape.at[k] * rod.axis);
    }
}

/// A body by its index, as the impact laws see it.
inline ImpactBody impact_body_of(const Spheres& spheres, std::uint32_t body) {
    const auto beads = static_cast<std::uint32_t>(spheres.beads.size());
    if (body < beads) {
        const Vec4d &velocity = spheres.beads.velocity[body], &spin = spheres.beads.spin[body];
        return {.velocity = vector_of(velocity),
                .spin = vector_of(spin),
                .axis = {1.0, 0.0, 0.0},
                .mass_inverse = velocity[3],
                .across_inverse = spin[3],
                .along_inverse = spin[3]};
    }
    const std::uint32_t r = body - beads;
    return impact_body_of(spheres.rods.rod[r], spheres.shape_of_rod(r));
}

/// Writes the velocities back.
inline void store(const ImpactBody& from, Spheres& spheres, std::uint32_t body) {
    const auto beads = static_cast<std::uint32_t>(spheres.beads.size());
    if (body < beads) {
        set_vector(spheres.beads.velocity[body], from.velocity);
        set_vector(spheres.beads.spin[body], from.spin);
    } else {
        Rod& rod = spheres.rods.rod[body - beads];
        rod.velocity = from.velocity;
        rod.angular_momentum = angular_momentum(from);
    }
}

/// From the centre of mass of its body to the centre of a sphere [mm].
inline Vector from_centre(const Spheres& spheres, std::uint32_t sphere) {
    if (spheres.is_bead(sphere)) return {};
    return vector_of(spheres.position[sphere]) - spheres.rods.rod[spheres.rod(sphere)].position;
}

/// From the centre of mass to the point of contact of a sphere, on the side (1 or -1) against the normal, where
/// `inside` of its radius is overlapped.
inline Vector arm_of(const Spheres& spheres, std::uint32_t sphere, double side, const Vector& normal, double inside) {
    return from_centre(spheres, sphere) - side * (spheres.position[sphere][3] - inside) * normal;
}

}  // namespace drover::dem
