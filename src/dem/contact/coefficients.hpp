// dem/contact/coefficients.hpp: restitution, friction and impact counts of a contact, by the kinds of its bodies.
#pragma once
#include "dem/neighbours/overlaps.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

struct Coefficients {
    double restitution = 0.0, friction = 0.0;
};

inline Coefficients plate_coefficients(const Restitution& e, const Friction& mu, bool bead) {
    return bead ? Coefficients{e.bead_plate, mu.bead_plate} : Coefficients{e.rod_plate, mu.rod_plate};
}

inline Coefficients coefficients_of(const Overlap& overlap, const Spheres& spheres, const Restitution& e,
                                    const Friction& mu) {
    const bool bead = spheres.is_bead(overlap.first);
    if (overlap.second == Overlap::side_wall)
        return bead ? Coefficients{e.bead_wall, mu.bead_wall} : Coefficients{e.rod_wall, mu.rod_wall};
    if (overlap.is_with_surface()) return plate_coefficients(e, mu, bead);
    if (spheres.is_bead(overlap.second) != bead) return {e.rod_bead, mu.rod_bead};
    return bead ? Coefficients{e.bead_bead, mu.bead_bead} : Coefficients{e.rod_rod, mu.rod_rod};
}

inline void count_impact(const Overlap& overlap, const Spheres& spheres, Counts& counts) {
    const bool first = spheres.is_bead(overlap.first);
    if (overlap.second == Overlap::side_wall) ++(first ? counts.bead_wall : counts.rod_wall);
    else if (overlap.is_with_surface()) ++(first ? counts.bead_plate : counts.rod_plate);
    else if (spheres.is_bead(overlap.second) != first) ++counts.rod_bead;
    else ++(first ? counts.bead_bead : counts.rod_rod);
}

}  // namespace drover::dem
