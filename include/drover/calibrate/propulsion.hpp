// calibrate/propulsion.hpp: how fast rods go in the bed.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct PropulsionPlan {
    double warm_up = 1.0;  ///< [s]
    double time = 4.0;     ///< followed [s]
    double frame = 0.025;  ///< over which a displacement is taken [s]: the 1/40 s of the experiment
};

/// u: speed of rods along themselves, among beads whose mean velocity is held at zero.  Over frames, d the displacement and n at its start,
///     u = <d.n>/frame x/(1 - exp(-x)),   x = -ln <n(0).n(frame)>:
/// a direction that diffuses shortens d.n by (1 - exp(-D_r frame))/(D_r frame); jitter of n does so too, to first order by x/2.
/// Quantities: propulsion u [mm/s]; propulsion_spread [mm/s], standard deviation among rods of their mean <d.n>/frame over a trial (that of
/// rods that differ, of gaits and, in short trials, of chance).
Assay propulsion(const PropulsionPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::PropulsionPlan>>& schema<calibrate::PropulsionPlan>();
}  // namespace drover
