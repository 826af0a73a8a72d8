// calibrate/assays/relaxation.hpp: rotational diffusion of single rods in the bed.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct RelaxationPlan {
    double warm_up = 1.0;  ///< before rods are recorded [s] >= 0
    double frame = 0.025;  ///< between samples [s]; a multiple of the plate period, at which rods tilt
    double time = 6.0;     ///< recorded [s]
    double max_lag = 2.0;  ///< longest lag [s], less than `time`; about 0.5/a if affordable

    static Rows<RelaxationPlan> rows();
};

/// a of the equations, from the directions theta of all rods:
///     C(t) = <cos(theta(s + t) - theta(s))>,   C(t) = c exp(-a t)  in the exponential regime,   a = D_r in 2-D.
/// d<n>/dt = -a <n> is (polarfull) for rods without flow and gradients, so the mean bead velocity is held at zero.
/// C has three regimes: an immediate loss 1 - c by jitter (bouncing, tilt) that does not accumulate; a curved part
/// while rods persist in turning; then a straight line in ln C.  ln C is fitted from a lag t0 on, with weights 1/t^2
/// (long lags have few independent intervals), up to -ln C = 1/2.  t0 is chosen once, from all trials together: the
/// first of 1, 2, 4, ... frames whose slope agrees with the slope from 2 t0 on within the error of their difference
/// (jackknife over trials), times two.  No time average is subtracted from C, and the logarithm is taken of its mean
/// over trials, so trials may be shorter than 1/a.
/// Quantities: relaxation_rate a [1/s]; rotational_jitter 1 - c, negative if persistence costs more correlation than
/// jitter; exponential_from t0 [s], NaN if there is no such lag.
/// Source: physics as in Kumar et al., Nat. Commun. 5, 4688 (2014), Methods.
Assay relaxation(const RelaxationPlan& plan = {});

}  // namespace drover::calibrate
