// calibrate/weathercock.hpp: how flow turns rods.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Speeds and times of a trial.
struct WeathercockPlan {
    std::vector<double> speeds = {1.0, 2.0, 5.0, 10.0};  ///< of the beads [mm/s] > 0, ascending
    double distance = 6.0;    ///< that the flow goes while rods turn [mm]: at most some 1/lambda_s
    double max_window = 1.5;  ///< that it takes [s]: slow flows go less far
    double torque = 2e4;      ///< holds rods athwart before [mg mm^2/s^2]; more than the flow's
    double warm_up = 1.0;     ///< once [s]
    double align = 0.5;       ///< before each release [s]
    double settle = 0.05;     ///< after it, for the angular velocity to become that of the flow [s]
    double frame = 0.025;     ///< most between looks [s]
};

/// lambda_s of one rod, and lambda = lambda_s/2 of the equations, of either sign (positive: rods turn along the flow).  An overdamped rod in a flow v
/// obeys  d theta/dt = lambda_s |v| sin(angle of v - theta) + noise  (dn/dt = lambda_s (1 - nn).v; averaged over directions (polarfull) has half of it).
/// All rods are held along x by an orienting torque while the mean velocity of the beads is held along y; the torque goes, the flow stays.  Then,
/// whatever noise that does not know of left and right, and for any spread of directions,
///     <theta(t) - theta(0)> = lambda_s v int_0^t <cos theta> ds:
/// no rotational diffusion enters, and a window longer than the initial turn is used.  Windows are distance/v long, at most max_window.  Each speed is taken with the flow to
/// either side and the mean of the mirror pair is used, which has no drift.  lambda_s is from all speeds: the
/// squares of the errors of theta - theta(0) go as the length t of the window and what is sought as v t, so speeds have weights v.
/// Linearity: lambda_s(v) = lambda_0 [1 + (x - 1) ln v], weights v: the turning rate goes as v^x near x = 1.
/// Quantities: weathercock_single lambda_s [1/mm]; weathercock lambda [1/mm]; turning_exponent x; weathercock_single_<v>, lambda_s at each speed.
Assay weathercock(const WeathercockPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::WeathercockPlan>>& schema<calibrate::WeathercockPlan>();
}  // namespace drover
