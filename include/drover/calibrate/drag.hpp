// calibrate/drag.hpp: how fast aligned rods carry the beads.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Fields and times of a trial.
struct DragPlan {
    std::vector<double> torques = {
        200.0, 500.0, 1500.0,
        10000.0};          ///< orienting, weak to strong [mg mm^2/s^2] > 0, for P from below a half to near one
    double warm_up = 0.5;  ///< once, in the strongest, for the packing to become a bed [s]; less than m rho/Gamma
    double time = 6.0;     ///< in each [s]; together some times m rho/Gamma and 1/a
    int windows = 4;       ///< of equal length that it is cut into
    double frame = 0.025;  ///< between looks at P [s]
    bool bend = true;      ///< with the term in |P|^2 P; else alpha/Gamma and tau are of a straight line
};

/// alpha/Gamma at the area fractions of the setup, in the normalisation in which P is the mean of n (a speed).  Rods are held along x by an orienting field of
/// several strengths, the strongest first, and beads are free and start at rest.  For the mean over the cell (beadmom) is  tau dv/dt = -v + (alpha/Gamma) P,  tau = m rho/Gamma;  here with the next order
/// that symmetry allows, and its mean over a window of length T:
///     <v> = (alpha/Gamma) <P> + c <|P|^2 P> - tau [v(T) - v(0)]/T,
/// which holds however P fluctuates and wherever v comes from: nothing need have settled.  Least squares over the windows of all torques, along x; alpha/Gamma is
/// the slope at the origin of the whole curve, or, without `bend`, that of the line through the origin; c is told in either case.
/// Quantities: drag alpha/Gamma [mm/s]; drag_curvature c [mm/s]; response_time tau [s], told by what had not settled, the start above all: tau far below a
/// window is told badly, and noise draws it to 0.  Its Gamma is all that stops the beads: the plates, which damping() has alone, and rods that do not
/// move along with them. A strong torque also lays rods flat and changes how they go: torques should be the weakest that order them.  Also order_<h> and flow_<h>, <P> and <v> in the last window of each torque h.
Assay drag(const DragPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::DragPlan>>& schema<calibrate::DragPlan>();
}  // namespace drover
