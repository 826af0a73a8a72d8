// physics/body_force.hpp: a force at a point that may move, mode by mode.
#pragma once
#include <cmath>

#include "drover/physics/term.hpp"

namespace drover::physics {

inline VectorMode point_force_mode(const BodyForce& force, const numerics::Grid& grid, double t,
                                   const numerics::Wavevector& q) {
    const double x = force.at_x + force.velocity_x * t, y = force.at_y + force.velocity_y * t;
    const double spread = std::exp(-0.5 * force.width * force.width * (q.x * q.x + q.y * q.y)) / numerics::area(grid);
    const std::complex<double> phase = spread * std::polar(1.0, -(q.x * x + q.y * y));
    return {force.x * phase, force.y * phase};
}

}  // namespace drover::physics
