// dem/contact/contact_report.hpp: contributions of contacts to the energy balance, the counts and the largest overlap;
// what became non-finite or overlapped too far, and why, for the messages of a failed run.
#pragma once
#include <string>

#include "dem/neighbours/overlaps.hpp"
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

}  // namespace drover::dem
