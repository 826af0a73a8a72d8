// physics/body_force.hpp: the force on the beads from outside, mode by mode.
#pragma once
#include <cmath>
#include <complex>

#include "drover/numerics/grid.hpp"
#include "drover/physics/terms.hpp"

namespace drover::physics {

/// The force from outside on one mode, divided by nothing.
struct ForceMode {
    std::complex<double> x = 0.0, y = 0.0;
};
inline ForceMode force_mode(const BodyForce& force, const numerics::Grid& grid, double t,
                            const numerics::Wavevector& q) {
    if (force.kind == "uniform") return q.x == 0.0 && q.y == 0.0 ? ForceMode{force.x, force.y} : ForceMode{};
    const double x = force.at_x + force.velocity_x * t, y = force.at_y + force.velocity_y * t;
    const double spread = std::exp(-0.5 * force.width * force.width * (q.x * q.x + q.y * q.y)) / numerics::area(grid);
    const std::complex<double> phase = spread * std::polar(1.0, -(q.x * x + q.y * y));
    return {force.x * phase, force.y * phase};
}

}  // namespace drover::physics
