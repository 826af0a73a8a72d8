// measure/particles_boxes.hpp: numbers of bodies in boxes, and rows of what is counted since the start.
#pragma once
#include <span>
#include <vector>

#include "drover/measure/particles.hpp"

namespace drover::measure {

/// out[b] = variance over all positions on the counting mesh of the number of bodies in box b.
void box_variances(const ParticleSetting& setting, std::span<const dem::Vector> places, std::span<double> out);

template <class Body>
void box_variances(const ParticleSetting& setting, const std::vector<Body>& bodies, std::span<double> out) {
    std::vector<dem::Vector> places;
    places.reserve(bodies.size());
    for (const Body& body : bodies) places.push_back(body.position);
    box_variances(setting, std::span<const dem::Vector>(places), out);
}

/// Energies, work, impacts and overlaps.
void add_balance(const ParticleSetting& setting, std::vector<ParticleObservable>& rows);

}  // namespace drover::measure
