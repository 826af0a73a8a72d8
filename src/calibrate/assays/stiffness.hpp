// calibrate/assays/stiffness.hpp: response of the bead density to a force.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Forces and times of a trial.
struct StiffnessPlan {
    int waves = 2;                              ///< of the force across the cell
    std::vector<double> pushes = {10.0, 20.0};  ///< two force amplitudes on a bead, ascending > 0 [mg mm/s^2]
    bool among_rods = false;                    ///< whether the rods of the setup are in the bed
    double torque = 300.0;                      ///< of the field that holds them across the force [mg mm^2/s^2]
    double warm_up = 0.5;                       ///< once, at the start [s]
    /// After each change of the force, until sound has decayed [s]: about 4 m rho/(Gamma + eta q^2).
    double settle = 2.0;
    double time = 2.0;    ///< averaged under each force [s]
    double frame = 0.02;  ///< between samples [s]

    static Rows<StiffnessPlan> rows();
};

/// Stiffness E of beads, without rods or among them, from the density response to a standing force wave f sin(qx) on
/// each bead.  (beadmom) with number density rho contains the force density rho f sin(qx); at rest
///     0 = rho f sin(qx) - E d rho/dx,
/// so  rho = rho_0 (1 + d cos(qx))  with  d = -f/(E q)  to first order:
///     E = -f/(q d)   [mg mm^2/s^2],   (speed of sound)^2 = E/m without damping.
/// (If rho is a mass density, divide E by the mass m of a bead; if an area fraction, by its area.)  Friction does not
/// enter: beads are shaken and at rest on average.  Forces of both signs are applied and averaged.
/// Two amplitudes: E is the least-squares line of d on f through the origin; `response_ratio` is (d/f at the larger)/
/// (d/f at the smaller), 1 if linear.  E is not available if d is less than 3 standard errors from 0, since 1/d then
/// has no mean.
/// Among rods a field along y holds their directions, so that neither their propulsion nor their order is along the
/// force; their centres are free. rods_follow is the part by which their density follows that of the beads: with a
/// force F grad sigma of the rods, what is measured is E + F (sigma/rho) rods_follow.
/// F is not measured: a force on the rods moves them relative to a bed that flows, and self-propelled rods are never at
/// rest, so E grad rho + F grad sigma = 0 cannot be observed; its origin in a table is `set`.
/// Quantities: stiffness E; density_response -d/f [s^2/(mg mm)]; response_ratio; among rods also rods_follow.
Assay stiffness(const StiffnessPlan& plan = {});

}  // namespace drover::calibrate
