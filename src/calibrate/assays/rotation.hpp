// calibrate/assays/rotation.hpp: rotational diffusion of single rods from mean-square angles.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct RotationPlan {
    double warm_up = 1.0;  ///< before angles are recorded [s] >= 0
    double frame = 0.05;   ///< between recorded angles [s] > 0; a rod turns by less than half a turn in it
    double time = 10.0;    ///< recorded [s]
    double min_lag = 0.5;  ///< shortest lag of the fit [s]; longer than a rod keeps its rate of turning
    double max_lag = 2.5;  ///< longest lag of the fit [s]; less than `time`

    static Rows<RotationPlan> rows();
};

/// D_r of single rods among beads whose mean velocity is held at zero, from the slope of the mean-square angle:
///     <[theta(s + t) - theta(s)]^2> = c + 2 D_r t,   min_lag <= t <= max_lag,
/// averaged over rods and start times s and fitted by least squares with weights 1/t^2.  The offset c holds jitter of
/// the axis (c > 0) and persistence of the rate of turning (c < 0).  relaxation_rate, from the mean direction, equals
/// D_r where a rod turns in many small steps, and not where it turns in few large ones, whose squares D_r counts.
/// Quantities: rotational_diffusion D_r [1/s]; rotational_offset c [1]; rotational_change: (D_r of the longer half of
/// the lags - D_r of the shorter half)/D_r, 0 for diffusive turning.
Assay rotation(const RotationPlan& plan = {});

}  // namespace drover::calibrate
