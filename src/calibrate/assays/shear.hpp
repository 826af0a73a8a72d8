// calibrate/assays/shear.hpp: shear viscosity of the beads.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Waves and times of a trial.
struct ShearPlan {
    std::vector<double> waves = {1, 3, 5};  ///< across the cell, integers >= 1, ascending: q = 2 pi waves/ly
    double speed = 10.0;                    ///< initial amplitude at each release [mm/s]
    double min_fraction = 0.2;              ///< of the initial amplitude, at which the fit of the decay ends
    double warm_up = 0.5;                   ///< once, at the start [s]
    double hold = 0.2;                      ///< before each release [s]
    int releases = 2;                       ///< of each wave, with alternating sign
    double time = 0.8;                      ///< recorded after each release [s]
    double frame = 0.01;                    ///< between samples [s]; a multiple of the plate period

    static Rows<ShearPlan> rows();
};

/// eta and Gamma of beads without rods, from the decay of waves v_x = A sin(q y), which (beadmom) damps at the rate
///     r(q) = (Gamma + eta q^2)/(m rho),
/// a straight line in q^2, fitted with weights 1/r^2.  The amplitude is held, then released.  r comes from the frames
/// in which the mean amplitude over all trials exceeds min_fraction of the first:
///     (A_0 - A_n)/sum of trapezoids = (2/frame) tanh(r frame/2),  exact for an exponential.
/// A wave contains all speeds from 0 to A: if damping() finds a Coulomb-like part, Gamma here is a mean over them.
/// Quantities: viscosity_kinematic eta/(m rho) [mm^2/s]; damping_intercept Gamma/(m rho) [1/s]; shear_bend, the largest
/// residual of r relative to r; shear_rate_<k>, r of each wave [1/s].  Multiply by m rho for eta [mg/s] and Gamma
/// [mg/(mm^2 s)].
Assay shear(const ShearPlan& plan = {});

}  // namespace drover::calibrate
