// dem/contact_report.hpp: contributions of contacts to the energy balance, the counts and the largest overlap.
#pragma once
#include "drover/dem/world.hpp"
#include "overlaps.hpp"

namespace drover::dem {

void add(const EnergyBalance& part, EnergyBalance& total);
void add(const Counts& part, Counts& total);

/// Results of a chunk of the work; chunks are added in order.
struct ContactReport {
    EnergyBalance balance;
    Counts counts;
    Overlap deepest;      ///< of this step
    double depth = -1.0;  ///< its relative_depth()
};

inline void record_depth(const Overlap& overlap, const Spheres& spheres, ContactReport& report) {
    if (const double depth = relative_depth(overlap, spheres); depth > report.depth) {
        report.depth = depth;
        report.deepest = overlap;
    }
}

inline void add(const ContactReport& part, ContactReport& total) {
    add(part.balance, total.balance);
    add(part.counts, total.counts);
    if (part.depth <= total.depth) return;
    total.depth = part.depth;
    total.deepest = part.deepest;
}

}  // namespace drover::dem
