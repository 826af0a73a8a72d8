// dem/contact/contact_report.hpp: contributions of contacts to the energy balance, the counts and the largest overlap;
// what became non-finite or overlapped too far, and why, for the messages of a failed run; restitution, friction and
// impact counts of a contact, by the kinds of its bodies, and the impact of two beads.
#pragma once
#include <optional>
#include <string>

#include "dem/flight/step_rules.hpp"
#include "dem/neighbours/neighbours.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

/// A sphere, or a surface of Overlap.
Name name_of(const Spheres& spheres, std::uint32_t sphere);

/// The first body with a position, velocity, axis or spin that is not finite, and its value; empty if there is none.
std::string first_non_finite(const Spheres& spheres);

/// The first body that moves by more than its radius in a step [s], so that it could pass through others, and what to
/// change; empty if there is none.
std::string first_too_fast(const Spheres& spheres, double step);

/// A contact whose impulse is not finite: its bodies with their state before the impact, and its coefficients.
std::string describe_impact(const Overlap& overlap, const Spheres& spheres, double restitution, double friction,
                            std::size_t contacts);

/// Speed at which two overlapping spheres, or a sphere and a surface at rest, approach [mm/s]; < 0: they part.
double closing_speed(const Overlap& overlap, const Spheres& spheres);

/// The step within which two bodies come to overlap, and its input key.
struct NamedStep {
    const char* key;
    double length;  ///< [s]
};

/// Why two bodies overlap too far, and what to change.  closing: their speed of approach at the time.
std::string cause_of_overlap(const Setup& setup, double depth, double radius, double closing, const NamedStep& step);

/// The input keys behind the work that is not finite, or else the largest.
std::string cause_of_energy(const EnergyBalance& balance);

void add(const EnergyBalance& part, EnergyBalance& total);
void add(const Counts& part, Counts& total);

/// Results of a chunk of the work; chunks are added in order.
struct ContactReport {
    EnergyBalance balance;
    Counts counts;
    Overlap deepest;       ///< of this step
    double depth = -1.0;   ///< its relative_depth()
    double closing = 0.0;  ///< its closing_speed() before the impact
    std::string failure;   ///< the first impulse that is not finite
};

inline void record_depth(const Overlap& overlap, const Spheres& spheres, ContactReport& report) {
    if (const double depth = relative_depth(overlap, spheres); depth > report.depth) {
        report.depth = depth;
        report.deepest = overlap;
        report.closing = closing_speed(overlap, spheres);
    }
}

inline void keep_deepest(const ContactReport& part, ContactReport& total) {
    if (part.depth <= total.depth) return;
    total.depth = part.depth;
    total.deepest = part.deepest;
    total.closing = part.closing;
}

inline void add(const ContactReport& part, ContactReport& total) {
    add(part.balance, total.balance);
    add(part.counts, total.counts);
    if (total.failure.empty()) total.failure = part.failure;
    keep_deepest(part, total);
}

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
