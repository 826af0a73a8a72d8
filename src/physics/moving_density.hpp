// physics/moving_density.hpp: a lower bound of the density whose mass moves.
#pragma once
#include <cmath>
#include <cstddef>

namespace drover::physics {

/// (density^16 + floor^16)^(1/16); see RightHandSide::set_step().
inline double moving_density(double density, double floor) {
    const double ratio = floor / density, square = ratio * ratio, fourth = square * square, eighth = fourth * fourth;
    return density * std::sqrt(std::sqrt(std::sqrt(std::sqrt(1.0 + eighth * eighth))));
}

/// The mass per area that moves at densities of which the least is `least_density`.
struct MovingMass {
    double of_bead, floor, least_density;
};

/// inverse = 1/(mass of a bead times moving_density), at each of `size` densities.
inline void invert(const MovingMass& mass, const double* density, std::size_t size, double* inverse) {
    if (!(mass.floor <= 0.25 * mass.least_density)) {
        for (std::size_t i = 0; i < size; ++i)
            inverse[i] = 1.0 / (mass.of_bead * moving_density(density[i], mass.floor));
        return;
    }
    // 1 - x/16 is (1 + x)^(-1/16) to less than 1e-20, and costs no roots.
    const double over_mass = 1.0 / mass.of_bead;
    for (std::size_t i = 0; i < size; ++i) {
        const double over = 1.0 / density[i], ratio = mass.floor * over, square = ratio * ratio,
                     fourth = square * square, eighth = fourth * fourth;
        inverse[i] = over_mass * (over - over * (eighth * eighth) * 0.0625);
    }
}

}  // namespace drover::physics
