// dem/contact/body_access.hpp: a body of a world, by its index, as the impact laws see it.
#pragma once
#include "dem/flight/spheres.hpp"
#include "dem/impact/impact.hpp"

namespace drover::dem {

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
