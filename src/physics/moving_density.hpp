// physics/moving_density.hpp: a lower bound of the density whose mass moves.
#pragma once
#include <cmath>

namespace drover::physics {

/// (density^16 + floor^16)^(1/16); see RightHandSide::set_step().
inline double moving_density(double density, double floor) {
    const double ratio = floor / density, square = ratio * ratio, fourth = square * square, eighth = fourth * fourth;
    return density * std::sqrt(std::sqrt(std::sqrt(std::sqrt(1.0 + eighth * eighth))));
}

}  // namespace drover::physics
