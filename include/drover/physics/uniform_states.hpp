// physics/uniform_states.hpp: uniform stationary states and the effective coefficients of slow order about them.
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "drover/physics/equations.hpp"

namespace drover::physics {

/// A uniform stationary state.
struct StationaryState {
    std::string name;             ///< isotropic; ordered; [weakly] along the field, [weakly] against the field
    UniformPoint point;           ///< without an external field the order of a flock is along x
    bool free_direction = false;  ///< the state is degenerate: p may have any direction
};

/// Whether the state has no order and the beads are at rest.
inline bool is_isotropic(const UniformPoint& point) {
    return point.order.norm() == 0.0 && point.velocity.norm() == 0.0;
}

/// Whether the state is invariant under reflection in the line of its direction: order and velocity are collinear.
bool is_mirrored(const UniformPoint& point);

struct StationaryStates {
    std::vector<StationaryState> states;  ///< isotropic first; may be empty
    std::string no_order;                 ///< why there is no ordered state; empty if there is one
};

/// All uniform stationary states at given densities: the real roots P of
///     (b - lambda alpha_3/Gamma) P^3 + (a - lambda alpha/Gamma) P = |H|,    H = h + lambda f/Gamma,
///     v = [(alpha + alpha_3 |p|^2) p + f]/Gamma,
/// where p is P along H.  If H = 0: the isotropic state and, if its root is real, the flock.  Beads without drag
/// (Gamma = 0) have p = -f/alpha; without driving they are at rest.  Throws an input Error if the densities are outside
/// a coefficient table.
/// If text terms change the uniform equations: the states that Newton's method finds from 7 magnitudes of the order, in
/// 16 directions if the equations are not isotropic.
StationaryStates stationary_states(const Equations& equations, double bead_density, double rod_density);
inline StationaryStates stationary_states(const Equations& equations) {
    return stationary_states(equations, equations.model.uniform.bead_density, equations.model.uniform.rod_density);
}

/// The effective coefficients of slow order after elimination of the bead velocity, which govern the long waves of a
/// flock.  Source: Kumar et al. (2014), Methods, with the additional factor chi, which divides the rates of all slow
/// modes of p.  In a form without bead velocity they are those of the order alone.
struct EffectiveCoefficients {
    double inertia = 1.0;              ///< chi = 1 + m rho lambda alpha/Gamma^2; 1 when v is slaved or absent
    double relaxation = 0.0;           ///< abar = a - lambda alpha/Gamma [1/s]; < 0: a flock
    double relaxation_by_beads = 0.0;  ///< d abar/d rho [mm^2/s]
    double relaxation_by_rods = 0.0;   ///< d abar/d sigma [mm^2/s]
    double pressure_beads = 0.0;       ///< Abar = A + lambda E/Gamma
    double pressure_rods = 0.0;        ///< Bbar = B + lambda F/Gamma
    double stiffness_across = 0.0;     ///< Kbar of waves of the order across q [mm^2/s]: K3 + lambda alpha eta/Gamma^2
    /// Kbar of waves of the order along q [mm^2/s]: K3 + K1 + lambda alpha (eta + zeta)/Gamma^2.
    double stiffness_along = 0.0;
    double sound_stiffness = 0.0;  ///< C0 [mm^2/s^2]: sound transverse to a flock has the speed sqrt(C0/chi)
    /// xi [mm]: the order transverse to q is neutral at q^2 = -1/xi^2.  Infinite at abar = 0; NaN at abar < 0, where
    /// `neutral_wavenumber` is defined instead.
    double correlation_length = std::numeric_limits<double>::quiet_NaN();
    /// q_c [1/mm] of the isotropic state at abar < 0.
    double neutral_wavenumber = std::numeric_limits<double>::quiet_NaN();
};

/// abar alone.  Throws as stationary_states.
double effective_relaxation(const Equations& equations, double bead_density, double rod_density);

/// Throws as stationary_states.  If Gamma = 0 with beads, quantities divided by Gamma are not finite.
EffectiveCoefficients effective_coefficients(const Equations& equations, double bead_density, double rod_density);

}  // namespace drover::physics
