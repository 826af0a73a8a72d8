// calibrate/assays/drag.hpp: speed at which aligned rods drag the beads.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Fields and times of a trial.
struct DragPlan {
    /// Of the orienting field, ascending [mg mm^2/s^2]; for P from below a half to nearly one.  One < 0 may come first.
    std::vector<double> torques = {200.0, 500.0, 1500.0, 10000.0};
    double warm_up = 0.5;  ///< once, in the strongest field [s]: the packing becomes a bed; less than m rho/Gamma
    double time = 6.0;     ///< in each field [s]; together several times m rho/Gamma and 1/a
    int windows = 4;       ///< of equal length in that time
    double frame = 0.025;  ///< between samples of P [s]
    bool bend = true;      ///< whether alpha/Gamma and tau come from the fit with a term in |P|^2 P, or without

    static Rows<DragPlan> rows();
};

/// alpha/Gamma at the area fractions of the setup, normalised such that P is the mean of n (so it is a speed).  An
/// orienting field of several strengths, the strongest first, holds the rods along x; the beads are free and start at
/// rest.  For the mean over the cell (beadmom) reads  tau dv/dt = -v + (alpha/Gamma) P,  tau = m rho/Gamma.  With the
/// next order that symmetry allows, its mean over a window of length T is
///     <v> = (alpha/Gamma) <P> + c <|P|^2 P> - tau [v(T) - v(0)]/T,
/// which holds for any fluctuations of P and any history of v, so no steady state is needed.  Least squares over the
/// windows of all torques, along x.  alpha/Gamma is the slope of the whole curve at the origin or, without `bend`, of
/// the straight line through the origin.  Only a reversal has orders near 0: without one that slope is extrapolated.
/// Quantities: drag alpha/Gamma [mm/s]; drag_cubic c = alpha_3/Gamma [mm/s], or drag_curvature where the straight line
/// was fitted, which tables do not use; response_time tau [s].  With `bend` also drag_straight, alpha/Gamma of the
/// straight line through the windows of torques > 0.  tau is determined by transients, mainly the start: it is
/// uncertain if far below a window, and noise biases it towards 0.  Its Gamma is the total friction on the beads: the
/// plates, which damping() measures alone, and rods that do not move along.
/// The same windows, but for a reversal, give the total alignment g of the rods, by flow and contacts:
///     kappa [1 + d_t P/(a P)] = g P + beta T,   P = I1(kappa)/I0(kappa),
/// which is linear in 1/a, and a is of another assay: g = alignment_steady + alignment_drift/a; alignment_reference, g
/// at 1/a = 10 s, has an error that tells their covariance.
/// Strong torques also lay rods flat and change their gait: use the weakest that order them.  Also order_<h> and
/// flow_<h>, <P> and <v> in the last window of each torque h.
Assay drag(const DragPlan& plan = {});

}  // namespace drover::calibrate
