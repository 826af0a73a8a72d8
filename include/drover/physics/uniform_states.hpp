// physics/uniform_states.hpp: the uniform states that the equations leave as they are, and the coefficients that rule
// about them.
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "drover/physics/equations.hpp"

namespace drover::physics {

/// A uniform stationary state.
struct StationaryState {
    std::string name;             ///< isotropic; ordered; along the field, against the field, each also weakly
    UniformPoint point;           ///< without a field from outside the order of a flock lies along x
    bool free_direction = false;  ///< every direction of p will do: the flock chose one
};

/// Without order and with the beads at rest: every direction is like every other.
inline bool is_isotropic(const UniformPoint& point) {
    return point.order.norm() == 0.0 && point.velocity.norm() == 0.0;
}

/// From where angles of waves are counted: the direction of the order; without it that of the beads' velocity; at rest
/// the x axis [rad].
double direction_of(const UniformPoint& point);

/// Whether the mirror image of the state in the line of its direction is the state itself: order and velocity on one
/// line.
bool is_mirrored(const UniformPoint& point);

struct StationaryStates {
    std::vector<StationaryState> states;  ///< isotropic first; may be empty
    std::string no_order;                 ///< why there is no ordered state; empty when there is one
};

/// All uniform stationary states at given densities: the real roots P of
///     b P^3 + (a - lambda alpha/Gamma) P = |H|,    H = h + lambda f/Gamma,    v = (alpha p + f)/Gamma,
/// p being P along H; without H the isotropic state and, where the roots are real, the flock.  Beads that nothing
/// holds back (Gamma = 0) have p = -f/alpha; without driving they are taken at rest.  Throws an input Error where a
/// coefficient refuses the densities (beyond its table).
/// Terms written as text that change the uniform equations: the states that Newton's method finds from 7 sizes of the
/// order, in 16 directions where the equations have one of their own.
StationaryStates stationary_states(const Equations& equations, double bead_density, double rod_density);
inline StationaryStates stationary_states(const Equations& equations) {
    return stationary_states(equations, equations.model.uniform.bead_density, equations.model.uniform.rod_density);
}

/// The coefficients of slow order, beads being carried along: what a flock's long waves see.  Source: Kumar et al.
/// (2014), Methods, with the factor chi: d_t of every slow mode of p is divided by it.  A form without bead velocity
/// has those of the order alone.
struct EffectiveCoefficients {
    double inertia = 1.0;              ///< chi = 1 + m rho lambda alpha/Gamma^2; 1 when v is slaved or absent
    double relaxation = 0.0;           ///< abar = a - lambda alpha/Gamma [1/s]; < 0: a flock
    double relaxation_by_beads = 0.0;  ///< d abar/d rho [mm^2/s]
    double relaxation_by_rods = 0.0;   ///< d abar/d sigma [mm^2/s]
    double pressure_beads = 0.0;       ///< Abar = A + lambda E/Gamma
    double pressure_rods = 0.0;        ///< Bbar = B + lambda F/Gamma
    double stiffness_across = 0.0;     ///< Kbar of waves of the order across q [mm^2/s]: K3 + lambda alpha eta/Gamma^2
    double stiffness_along =
        0.0;  ///< Kbar of waves of the order along q [mm^2/s]: K3 + K1 + lambda alpha (eta + zeta)/Gamma^2
    double sound_stiffness = 0.0;  ///< C0 [mm^2/s^2]: sound across a flock runs at sqrt(C0/chi)
    /// sqrt of what |q|^2 must be, with its sign turned, for the order across q neither to grow nor to decay [mm];
    /// infinite at abar = 0; not-a-number past it, where the neutral wave itself is `neutral_wavenumber`.
    double correlation_length = std::numeric_limits<double>::quiet_NaN();
    double neutral_wavenumber =
        std::numeric_limits<double>::quiet_NaN();  ///< q_c [1/mm] of the isotropic state past abar = 0
};

/// abar alone.  Throws as stationary_states.
double effective_relaxation(const Equations& equations, double bead_density, double rod_density);

/// Throws as stationary_states.  Gamma = 0 with beads: what is divided by it is not finite.
EffectiveCoefficients effective_coefficients(const Equations& equations, double bead_density, double rod_density);

}  // namespace drover::physics
