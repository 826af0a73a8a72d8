// calibrate/assays/weathercock.hpp: rotation of rods by bead flow.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Speeds and times of a trial.
struct WeathercockPlan {
    std::vector<double> speeds = {1.0, 2.0, 5.0, 10.0};  ///< of the beads [mm/s] > 0, ascending
    double distance = 6.0;                               ///< of the flow while rods turn [mm]: at most about 1/lambda_s
    double max_window = 1.5;                             ///< longest time for that distance [s]; slow flows go less far
    double torque = 2e4;   ///< that holds rods transverse to the flow before the release [mg mm^2/s^2]
    double warm_up = 1.0;  ///< once, at the start [s]
    double align = 0.5;    ///< before each release [s]
    double settle = 0.05;  ///< after each release, until the angular velocity follows the flow [s]
    double frame = 0.025;  ///< longest time between samples [s]

    static Rows<WeathercockPlan> rows();
};

/// lambda_s of one rod, and lambda = lambda_s/2 of the equations, of either sign (positive: rods turn along the flow).
/// An overdamped rod in a flow v obeys  d theta/dt = lambda_s |v| sin(angle of v - theta) + noise
/// (dn/dt = lambda_s (1 - nn).v; averaged over directions, (polarfull) has half of it).
/// An orienting torque holds all rods along x while the mean bead velocity is held along y; then the torque is switched
/// off.  For any noise that is symmetric under reflection, and any distribution of directions,
///     <theta(t) - theta(0)> = lambda_s v int_0^t <cos theta> ds,
/// so rotational diffusion does not enter, and windows longer than the initial turn are used: distance/v, at most
/// max_window.  Each speed is measured with the flow to either side and the mean of the mirror pair is used, which
/// cancels drift.  lambda_s combines all speeds with weights v: squared errors of theta - theta(0) grow as the window
/// length t and the signal as v t.
/// Linearity: lambda_s(v) = lambda_0 [1 + (x - 1) ln v], weights v: the turning rate goes as v^x near x = 1.
/// Quantities: weathercock_single lambda_s [1/mm]; weathercock lambda [1/mm]; turning_exponent x;
/// weathercock_single_<v>, lambda_s at each speed.
Assay weathercock(const WeathercockPlan& plan = {});

}  // namespace drover::calibrate
