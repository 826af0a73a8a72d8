// dem/contact/coefficients.hpp: restitution, friction and impact counts of a contact, by the kinds of its bodies, and
// the impact of two beads.
#pragma once
#include <optional>

#include "dem/contact/contact_report.hpp"
#include "dem/flight/step_rules.hpp"

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

inline bool is_pair_of_beads(const Overlap& overlap, const Spheres& spheres) {
    return !overlap.is_with_surface() && spheres.is_bead(overlap.first) && spheres.is_bead(overlap.second);
}

/// The impact of two beads, `apart` being the velocity of the first one relative to the second, n the normal towards
/// it, and ra and rb the distances of the centres from the point of contact.  Changes velocities and spins; returns the
/// impulse on the first one, or nothing where the beads part or the impulse is not finite.
inline std::optional<Vector> bounce_beads(const Overlap& overlap, const Vector& apart, const Vector& n, double ra,
                                          double rb, Spheres& spheres, const StepRules& rules, ContactReport& report) {
    BeadArrays& beads = spheres.beads;
    Vec4d &va = beads.velocity[overlap.first], &vb = beads.velocity[overlap.second];
    Vec4d &wa = beads.spin[overlap.first], &wb = beads.spin[overlap.second];
    const double opening = dot(apart, n), mass_inverse = va[3] + vb[3];
    if (opening >= 0.0) return std::nullopt;
    const Vector u = apart - cross(ra * vector_of(wa) + rb * vector_of(wb), n);
    const Vector slip = u - opening * n;
    const double size = length(slip), e = rules.restitution.bead_bead, mu = rules.friction.bead_bead;
    const SphereImpact impact = sphere_impact(opening, size, {.denominator = mass_inverse},
                                              mass_inverse + ra * ra * wa[3] + rb * rb * wb[3], e, mu);
    if (!std::isfinite(impact.normal + impact.friction_work)) {
        if (report.failure.empty()) report.failure = describe_impact(overlap, spheres, e, mu, 1);
        return std::nullopt;
    }
    const Vector along = size > 0.0 ? -impact.tangential / size * slip : Vector{};
    const Vector impulse = impact.normal * n + along, turn = cross(n, along);
    set_vector(va, vector_of(va) + va[3] * impulse);
    set_vector(vb, vector_of(vb) - vb[3] * impulse);
    set_vector(wa, vector_of(wa) - ra * wa[3] * turn);
    set_vector(wb, vector_of(wb) - rb * wb[3] * turn);
    report.balance.impact += 0.5 * impact.normal * (opening + opening + mass_inverse * impact.normal);
    report.balance.friction += impact.friction_work;
    if (opening < -counted_speed) ++report.counts.bead_bead;
    return impulse;
}

}  // namespace drover::dem
