// calibrate/damping.hpp: how plates stop the beads.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Speeds and times of a trial.
struct DampingPlan {
    double speed = 10.0;       ///< at the release [mm/s]
    double min_speed = 1.0;    ///< to which the decay is read: a decade [mm/s]
    double speed_flock = 3.0;  ///< at which the rate is wanted, between the two [mm/s]
    double warm_up = 0.5;      ///< once [s]
    double hold = 0.2;         ///< before each release [s]
    int releases = 2;          ///< of one system, along x, y, -x, -y, and so on
    double time = 4.0;         ///< followed after each [s]; until min_speed, some 3/(Gamma/(m rho))
    double frame = 0.05;       ///< between looks [s], whole periods of the plates
};

/// Gamma/(m rho) of beads without rods.  Their mean velocity is held, then released, and its decay followed:
///     dv/dt = -g v - c,    g [1/s] linear, c [mm/s^2] Coulomb-like,    Gamma/(m rho) = g + c/v at the speed v of the flock.
/// (A uniform velocity relaxes at Gamma/(m rho), see (beadmom).)  Over each frame  v - v' = g (x' - x) + c frame,  exactly, x the mean displacement of the
/// beads; least squares over the frames of the mean decay of all trials, while it is faster than min_speed, which frames these are being found
/// once, on all trials together.  Beads that stay faster than speed_flock have the mean of -dv/dx over the speeds they had, and no g and c.  Noise of the beads' collisions is the same in every frame: so are the weights.
/// Quantities: damping_rate Gamma/(m rho) at the flock's speed [1/s]; damping_linear g; damping_coulomb c; coulomb_share (c/v)/(g + c/v) at the flock's
/// speed; damping_rate_fast, _middle, _slow: (v - v')/(x' - x) over thirds of the decade (in ln v), the table of which a linear law makes one number.
/// Multiply by m rho for Gamma [mg/(mm^2 s)].
Assay damping(const DampingPlan& plan = {});

}  // namespace drover::calibrate

namespace drover {
template <>
const std::vector<Row<calibrate::DampingPlan>>& schema<calibrate::DampingPlan>();
}  // namespace drover
