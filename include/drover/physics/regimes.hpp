// physics/regimes.hpp: the stable uniform state at each point of a plane of models, and axes of such a plane.
#pragma once
#include <string>
#include <vector>

#include "drover/physics/phase_boundary.hpp"

namespace drover::physics {

/// The uniform state at a point, and whether long waves grow on it.
enum class Regime { undefined = -1, isotropic = 0, separating = 1, flock = 2, banding = 3, oblique = 4 };

/// "-1 not defined, 0 isotropic, ...": the codes and their meanings.
std::string regime_legend();

/// From the margins of the four limits; NaN: the state that the limit concerns does not exist.
Regime regime_of(double onset, double phase_separation, double banding, double oblique);

/// An area fraction as an axis: the density times the area of one particle.
struct AreaFraction {
    const char* name;  ///< bead_area_fraction, rod_area_fraction
    const char* area_key;
    double UniformState::*density;
    double UniformState::*area;
};
/// nullptr if the name is not an area fraction.
const AreaFraction* find_area_fraction(const std::string& name);

/// Sets the density of a model from an area fraction.  `area`: of one particle [mm^2], > 0.
PlaneAxis area_fraction_axis(const AreaFraction& fraction, double area, double from, double to);

/// Which uniform density a key or an area fraction sets.
enum class DensityAxis { none, beads, rods };
DensityAxis density_axis(const std::string& key);

/// Whether two keys set the same number.
bool is_same_axis(const std::string& key, const std::string& other);

/// Whether phase boundaries depend on a key.  Keys of noise and of particle areas do not affect them.
bool affects_boundaries(const std::string& key);

}  // namespace drover::physics
