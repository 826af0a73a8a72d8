// calibrate/assays/damping.hpp: damping of bead flow by the plates.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Speeds and times of a trial.
struct DampingPlan {
    double speed = 10.0;       ///< initial speed at each release [mm/s]
    double min_speed = 1.0;    ///< speed at which the fit of the decay ends [mm/s]; a decade below `speed`
    double speed_flock = 3.0;  ///< speed at which the rate is evaluated, between the other two [mm/s]
    double warm_up = 0.5;      ///< once, at the start [s]
    double hold = 0.2;         ///< before each release [s]
    int releases = 2;          ///< per system, along x, y, -x, -y, and so on
    double time = 4.0;         ///< recorded after each release [s]; until min_speed, about 3/(Gamma/(m rho))
    double frame = 0.05;       ///< between samples [s]; a multiple of the plate period

    static Rows<DampingPlan> rows();
};

/// Gamma/(m rho) of beads without rods.  The mean bead velocity is held, then released, and its decay recorded:
///     dv/dt = -g v - c,    g [1/s] linear, c [mm/s^2] Coulomb-like,    Gamma/(m rho) = g + c/v at the flock speed v.
/// (A uniform velocity relaxes at Gamma/(m rho), see (beadmom).)  Over each frame, exactly,
///     v - v' = g (x' - x) + c frame,
/// x being the mean displacement of the beads.  g and c are a least-squares fit over the frames of the mean decay of
/// all trials, as long as it is faster than min_speed; these frames are chosen once, from all trials together.  Noise
/// from collisions is the same in every frame, hence equal weights.  If the beads stay faster than speed_flock, the
/// rate is the mean of -dv/dx over the observed speeds, and g and c are not available.
/// Quantities: damping_rate Gamma/(m rho) at the flock speed [1/s]; damping_linear g; damping_coulomb c; coulomb_share
/// (c/v)/(g + c/v) at the flock speed; damping_rate_fast, _middle, _slow: (v - v')/(x' - x) over thirds of the decade
/// (in ln v), all equal for a linear law.  Multiply by m rho for Gamma [mg/(mm^2 s)].
Assay damping(const DampingPlan& plan = {});

}  // namespace drover::calibrate
