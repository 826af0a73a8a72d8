// measure/number_boxes.hpp: fluctuations of the number of bodies in boxes of a periodic cell.
#pragma once
#include <span>
#include <vector>

#include "measure/particles.hpp"

namespace drover::measure {

/// Variance over all positions on the counting mesh of the number of bodies in each box.
std::vector<double> box_variances(const ParticleSetting& setting, std::span<const dem::Vector> positions);

template <class Body>
std::vector<double> box_variances(const ParticleSetting& setting, const std::vector<Body>& bodies) {
    std::vector<dem::Vector> positions;
    positions.reserve(bodies.size());
    for (const Body& body : bodies) positions.push_back(body.position);
    return box_variances(setting, std::span<const dem::Vector>(positions));
}

}  // namespace drover::measure
