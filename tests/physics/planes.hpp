// tests/physics/planes.hpp: lines and margins of planes of rods and beads.
#pragma once
#include <vector>

#include "drover/physics/phase_boundary.hpp"

namespace drover::physics {

using model::Boundary;
using model::BoundaryLine;
using model::BoundaryPoint;

inline Boundary trace_boundary(const Plane& plane, Limit limit, const std::vector<Model>& draws,
                               const numerics::ContourOptions& options, const ComputeAll& compute) {
    const model::PlaneMargins margins = margins_over(plane, limit, draws);
    return model::trace_boundary({.x0 = plane.x.from, .x1 = plane.x.to, .y0 = plane.y.from, .y1 = plane.y.to},
                                 margins.at, margins.draws, options, compute);
}

inline std::vector<Margin> margins(const Plane& plane, const std::vector<numerics::PlanePoint>& points, Limit limit) {
    const model::PlaneMargins over = margins_over(plane, limit);
    std::vector<Margin> result;
    for (const numerics::PlanePoint& point : points) result.push_back(over.at(point));
    return result;
}

}  // namespace drover::physics
