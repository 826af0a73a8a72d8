// calibrate/assays/propulsion.hpp: speed of single rods in the bed.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct PropulsionPlan {
    double warm_up = 1.0;  ///< before rods are recorded [s]
    double time = 4.0;     ///< recorded [s]
    double frame = 0.025;  ///< over which a displacement is taken [s]; the experiment used 1/40 s

    static Rows<PropulsionPlan> rows();
};

/// u: speed of rods along their axis, among beads whose mean velocity is held at zero.  With the displacement d over a
/// frame and n at its start,
///     u = <d.n>/frame x/(1 - exp(-x)),   x = -ln <n(0).n(frame)>.
/// Rotational diffusion shortens d.n by (1 - exp(-D_r frame))/(D_r frame); jitter of n shortens it too, to first order
/// by x/2.
/// Quantities: propulsion u [mm/s]; propulsion_spread [mm/s], the standard deviation among rods of their mean
/// <d.n>/frame over a trial (from differences between rods, gaits and, in short trials, statistics).
Assay propulsion(const PropulsionPlan& plan = {});

}  // namespace drover::calibrate
