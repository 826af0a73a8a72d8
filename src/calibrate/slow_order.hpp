// calibrate/slow_order.hpp: what only rods and beads have: the effective coefficients of their slow order, and its
// saturation without that of the fluctuations of independent rods.
#pragma once
#include <string>
#include <vector>

#include "base/constants.hpp"
#include "numerics/steppers/kept_modes.hpp"
#include "physics/equations.hpp"
#include "physics/model_values.hpp"

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

/// 2 b s [1/s], by which -b |p|^2 p slows the growth of order in fields with noise, s the variance of p of independent
/// rods in the kept waves but q = 0: the sum of Delta/(2 A) [1/(a + K q^2 + K4 q^4)] over the two components, K = K3
/// across q and K3 + K1 along it, a without contacts.  Each wave of few rods has that much |p|^2, though none of them
/// turns less for it.  First order in b, by the means of products of Gaussian fluctuations.  Throws an input Error at
/// `where` unless a, b and Delta are positive, and a from no table.
double counterterm(const physics::ModelValues& model, const numerics::KeptGrid& on, const SourceLocation& where);

/// The same over a: by how much of itself the decay of order is too large in fields; 0 where nothing saturates.
double part_of_waves(const physics::ModelValues& model, const numerics::KeptGrid& on);

/// Makes order grow faster by so much.
void add_counterterm(double rate, physics::ModelValues& model);

}  // namespace drover::calibrate
