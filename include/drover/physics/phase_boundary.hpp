// physics/phase_boundary.hpp: stability boundaries of a uniform state in a plane of two model parameters.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/model/boundary.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/long_waves.hpp"

namespace drover::physics {

/// The kind of stability boundary.
enum class Limit {
    onset,             ///< abar = a - lambda alpha/Gamma = 0: the isotropic state becomes unstable to a flock
    phase_separation,  ///< isotropic state, abar > 0: an eigenvalue of the diffusion matrix becomes negative
    banding,           ///< flock: long waves along p0 grow
    oblique  ///< flock: long waves at any angle to p0 grow, however small the angle; includes the banding region
};
/// "onset", "phase-separation", "banding", "oblique".
std::string limit_name(Limit limit);
Limit limit_of(const std::string& name);  ///< throws an input Error that lists the valid names

using model::Margin;

/// Stability margin, exact in the limit q -> 0, by second-order perturbation theory; waves of finite length may become
/// unstable earlier, see model/instabilities.hpp.  NaN: the state of this limit does not exist, or the densities are
/// outside a table.  Its angle is that from p0.
Margin margin(const Equations& equations, double bead_density, double rod_density, Limit limit);

/// One axis of a plane of models.
struct PlaneAxis {
    std::string name;  ///< its scene key, or bead_area_fraction, rod_area_fraction
    std::string unit;
    double from = 0.0, to = 1.0;
    std::function<void(Model&, double)> set;
    bool is_density = false;  ///< changes only the uniform densities; the compiled coefficients remain valid
};

/// A parameter with a standard error; errors of different parameters are independent.
struct Uncertain {
    std::string name;
    double error = 0.0;
    std::function<void(Model&, double)> add;  ///< adds to the parameter
};

/// All table values of a model that have an error.
std::vector<Uncertain> table_errors(const Model& model);

/// Adds to these numbers of each model one draw of their errors; number n of `uncertain` has the same draws every time.
void draw_errors(const std::vector<Uncertain>& uncertain, std::vector<Model>& models);

struct Plane {
    Model model;
    PlaneAxis x, y;
};

/// The margins of one limit over a plane, and those of draws of its model within the errors.  Draws whose model is not
/// valid are left out: see DrawField::draws.  They throw an input Error that names a point whose model is invalid.
model::PlaneMargins margins_over(const Plane& plane, Limit limit, const std::vector<Model>& draws = {});

}  // namespace drover::physics
