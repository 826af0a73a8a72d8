// calibrate/shear.hpp: how beads drag each other along.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Waves and times of a trial.
struct ShearPlan {
    std::vector<double> waves = {1, 3, 5};  ///< across the cell, whole, ascending >= 1: q = 2 pi waves/ly
    double speed = 10.0;                    ///< amplitude at the release [mm/s]
    double min_fraction = 0.2;              ///< of it, to which the decay is read
    double warm_up = 0.5;                   ///< once [s]
    double hold = 0.2;                      ///< before each release [s]
    int releases = 2;                       ///< of each wave, to either side in turn
    double time = 0.8;                      ///< followed after each [s]
    double frame = 0.01;                    ///< between looks [s], whole periods of the plates
};

/// eta and Gamma of beads without rods, from the decay of waves v_x = A sin(q y), which (beadmom) damps at the rate
///     r(q) = (Gamma + eta q^2)/(m rho):
/// a straight line in q^2, fitted with weights 1/r^2.  The amplitude is held, then released.  r is from the frames while the mean amplitude over all trials
/// is above min_fraction of the first:  (A_0 - A_n)/sum of trapezoids = (2/frame) tanh(r frame/2) for an exponential, exactly.
/// A wave has all speeds from 0 to A: where damping() finds a Coulomb-like part, Gamma here is the mean slope over these.
/// Quantities: viscosity_kinematic eta/(m rho) [mm^2/s]; damping_intercept Gamma/(m rho) [1/s]; shear_bend, of r beside the line: the largest residual
/// over its rate; shear_rate_<k>, r of each wave [1/s].  Multiply by m rho for eta [mg/s] and Gamma [mg/(mm^2 s)].
Assay shear(const ShearPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::ShearPlan>>& schema<calibrate::ShearPlan>();
}  // namespace drover
