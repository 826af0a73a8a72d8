// dem/contact/contact_report.hpp: contributions of contacts to the energy balance, the counts and the largest overlap.
#pragma once
#include "dem/contact/diagnosis.hpp"
#include "dem/neighbours/overlaps.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

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
