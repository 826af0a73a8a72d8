// theory/density_profile.hpp: the plateaus of a density along a line.
#pragma once
#include <cstddef>
#include <span>

namespace drover::theory {

/// A density of a state between its extremes: two plateaus of coexisting phases, or a single wave.
struct DensityProfile {
    double low = 0.0, high = 0.0;                    ///< at the flattest points below and above the middle
    bool low_is_flat = false, high_is_flat = false;  ///< plateaus: both are phases that coexist
    std::size_t low_at = 0, high_at = 0;             ///< these points
    double width = 0.0;                              ///< of the part above the middle [mm]; 0: uniform to rounding
};

/// `density`: on the points of a line of length lx.
DensityProfile density_profile(std::span<const double> density, double lx);

}  // namespace drover::theory
