// tests/physics/linear_modes.hpp: linear modes of a uniform state of rods and beads.
#pragma once
#include <cmath>

#include "drover/theory/theory.hpp"
#include "uniform_points.hpp"

namespace drover::physics {

using theory::Growth;
using theory::Modes;

/// Those of theory/theory.hpp; angles are those from the direction of the state.
inline Modes modes(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q) {
    return theory::modes(*linearised(equations, about), q);
}
inline Eigen::VectorXcd mode_rates(const Equations& equations, const UniformPoint& about,
                                   const numerics::Wavevector& q) {
    return theory::mode_rates(*linearised(equations, about), q);
}
inline Growth growth(const Equations& equations, const UniformPoint& about, double q, double angle) {
    return theory::growth(*linearised(equations, about), q, angle);
}

/// The wavevector at an angle from the direction of the state.
inline numerics::Wavevector wavevector_from_order(const UniformPoint& about, double q, double angle) {
    const double direction = direction_of(about);
    return {.x = q * std::cos(direction + angle), .y = q * std::sin(direction + angle)};
}

}  // namespace drover::physics
