// tests/physics/flock_model.hpp: a flock of rods and beads in the normalisation of the closed forms (m = 1, u = 1, J =
// u p).
#pragma once
#include <cmath>

#include "linear_modes.hpp"
#include "physics/rod_bead_model.hpp"
#include "theory/instabilities.hpp"

namespace drover::physics {

/// The coefficients by the letters of the equations.
struct Letters {
    double rho = 1.3, gamma = 2.2, eta = 0.7, zeta = 0.4, alpha = 1.7, e = 0.9, f = 0.6, a = 0.5, b = 0.8, k3 = 0.45,
           k1 = 0.3, lambda = 1.1, w = 0.35, pressure_a = 0.25, pressure_b = 0.55;
    double abar() const { return a - lambda * alpha / gamma; }
    double chi() const { return 1.0 + rho * lambda * alpha / (gamma * gamma); }
    double bbar() const { return pressure_b + lambda * f / gamma; }
    double abar_beads() const { return pressure_a + lambda * e / gamma; }
    double c0() const { return bbar() + rho * alpha * abar_beads() / gamma; }
    double p0() const { return std::sqrt(-abar() / b); }
    double v0() const { return alpha * p0() / gamma; }
    double nu() const { return 2.0 * b * p0() * p0(); }
};

inline Model flock_model(const Letters& l) {
    return {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
            .uniform = {.rod_density = 0.9, .bead_density = l.rho},
            .current = {.speed = 1.0},
            .inertia = {.bead_mass = 1.0},
            .drag = {.coefficient = l.gamma},
            .viscosity = {.shear = l.eta, .bulk = l.zeta},
            .driving = {.strength = l.alpha},
            .stiffness = {.beads = l.e, .rods = l.f},
            .relaxation = {.rate = l.a, .saturation = l.b},
            .elasticity = {.stiffness = l.k3, .splay = l.k1},
            .weathercock = {.strength = l.lambda},
            .advection = {.strength = l.w},
            .pressure = {.beads = l.pressure_a, .rods = l.pressure_b}};
}

/// Above its threshold: the isotropic state is stable.
inline Letters isotropic_letters() { return {.a = 1.4}; }

inline StationaryState flock_of(const Equations& equations) { return stationary_states(equations).states.at(1); }
inline StationaryState isotropic_of(const Equations& equations) { return stationary_states(equations).states.at(0); }

inline std::vector<theory::Instability> instabilities(const Equations& equations, const StationaryState& about,
                                                      const theory::GrowthSearch& search) {
    Threads one(1);
    return theory::growing_waves(*linearised(equations, about.point), search, one).kinds;
}

}  // namespace drover::physics
