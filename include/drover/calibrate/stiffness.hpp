// calibrate/stiffness.hpp: how beads resist being pushed together.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Forces and times of a trial.
struct StiffnessPlan {
    int waves = 2;                              ///< of the force across the cell
    std::vector<double> pushes = {10.0, 20.0};  ///< two amplitudes of the force on a bead, ascending > 0 [mg mm/s^2]
    double warm_up = 0.5;                       ///< once [s]
    double settle = 2.0;  ///< after each change of the force, for its sound to die [s]: some 4 m rho/(Gamma + eta q^2)
    double time = 2.0;    ///< of the mean under each force [s]
    double frame = 0.02;  ///< between looks [s]
};

/// E of beads without rods, from the density that a standing force wave f sin(qx) on each bead makes.  (beadmom) with rho the number density takes the force
/// density rho f sin(qx); at rest  0 = rho f sin(qx) - E d rho/dx,  so  rho = rho_0 (1 + d cos(qx))  with  d = -f/(E q)  to first order:
///     E = -f/(q d)   [mg mm^2/s^2],   speed of sound^2 = E/m without damping.
/// (For rho a mass density E is that over the mass m of a bead, for an area fraction over its area.)  Friction has no part in it: beads are shaken,
/// and at rest on average.  Forces of both signs are taken, and the mean of the mirror pair used.
/// Two amplitudes: E is the least-squares line of d on f through the origin; `response_ratio` is (d/f of the larger)/(d/f of the smaller), 1 if linear.
/// E is refused where d is less than 3 standard errors from 0: then 1/d has no mean.
/// F is not measured: a force on the rods moves them against a bed that flows, and rods that swim are at no rest in which E grad rho + F grad sigma = 0 could
/// be read; its origin in a table is `set`.
/// Quantities: stiffness E; density_response -d/f [s^2/(mg mm)]; response_ratio.
Assay stiffness(const StiffnessPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::StiffnessPlan>>& schema<calibrate::StiffnessPlan>();
}  // namespace drover
