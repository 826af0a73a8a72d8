// calibrate/slow_order.hpp: what only rods and beads have: the effective coefficients of their slow order.
#pragma once
#include <string>
#include <vector>

#include "base/constants.hpp"
#include "physics/equations.hpp"

namespace drover::calibrate {

/// The effective coefficients of slow order after elimination of the bead velocity, which govern the long waves of a
/// flock.  Source: Kumar et al. (2014), Methods, with the additional factor chi, which divides the rates of all slow
/// modes of p.  In a form without bead velocity they are those of the order alone.
struct SlowOrder {
    double inertia = 1.0;              ///< chi = 1 + m rho lambda alpha/Gamma^2; 1 when v is slaved or absent
    double relaxation = 0.0;           ///< abar = a - c sigma - lambda alpha/Gamma [1/s]; < 0: a flock
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
    double correlation_length = nan;
    /// q_c [1/mm] of the isotropic state at abar < 0.
    double neutral_wavenumber = nan;
};

/// At the mean densities of the model.  Throws an input Error if they are outside a table, and for a term that depends
/// on position or time.  If Gamma = 0 with beads, quantities divided by Gamma are not finite.
SlowOrder slow_order(const physics::Equations& equations);

/// A number of a result, with its unit as UDUNITS text.
struct ResultRow {
    std::string name, unit, meaning;
    double value = 0.0;
    bool applies = true;  ///< the form has the fields that it needs
};
/// The effective coefficients, and the mean densities.
std::vector<ResultRow> slow_order_rows(const physics::Equations& equations, const SlowOrder& values);
std::vector<ResultRow> density_rows(const physics::Equations& equations);

/// What the reader of a stability analysis must know of the model.
std::vector<std::string> stability_remarks(const physics::Equations& equations, const SlowOrder& values);

/// Why the equations have no ordered uniform state, by their coefficients; "": these do not tell.
std::string why_no_order(const physics::Equations& equations);

}  // namespace drover::calibrate
