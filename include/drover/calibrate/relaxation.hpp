// calibrate/relaxation.hpp: how fast rods in the bed lose their direction.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct RelaxationPlan {
    double warm_up = 1.0;  ///< [s] >= 0
    double frame = 0.025;  ///< between looks [s]; whole periods of the plates, which tilt rods at their own frequency
    double time = 6.0;     ///< followed [s]
    double max_lag = 2.0;  ///< [s], less than `time`; some 0.5/a, or what there is time for
};

/// a of the equations, from the directions theta of all rods:
///     C(t) = <cos(theta(s + t) - theta(s))>,   C(t) = c exp(-a t)  in the exponential regime,   a = D_r in two dimensions.
/// d<n>/dt = -a <n> is (polarfull) for rods that feel neither flow nor gradients, so the mean velocity of the beads is held at zero.
/// Three regimes: at once, C loses 1 - c to jitter (bouncing, tilt) that does not add up; then it bends, while a rod still turns the way it turned;
/// then ln C is straight.  ln C is fitted from a lag t0 on, with weights 1/t^2 (few stretches of long lags are independent), as far as -ln C < 1/2.  t0 is
/// found once, on all trials together: among 1, 2, 4, ... frames the first whose slope agrees with that from 2 t0 on within the error of their
/// difference (jackknife over trials); then twice that is taken.  C has no mean over time taken off and its logarithm is that of the
/// mean over trials: trials may be shorter than 1/a.
/// Quantities: relaxation_rate a [1/s]; rotational_jitter 1 - c, below 0 where what is lost late (persistent turning) is more than
/// what is lost at once; exponential_from t0 [s], not-a-number if no such lag is found.
/// Source: physics as in Kumar et al., Nat. Commun. 5, 4688 (2014), Methods.
Assay relaxation(const RelaxationPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::RelaxationPlan>>& schema<calibrate::RelaxationPlan>();
}  // namespace drover
