// physics/long_waves.hpp: speeds and dampings of the slow modes of a uniform state, by angle, exact as q -> 0.
#pragma once
#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "drover/physics/equations.hpp"
#include "drover/physics/uniform_states.hpp"

namespace drover::physics {

/// A slow mode: s = -i u q - gamma q^2 as q -> 0.
struct SlowMode {
    /// u [mm/s]; Im u > 0: the mode grows, with rate proportional to q.
    std::complex<double> speed;
    /// gamma [mm^2/s]; Re gamma < 0: the mode grows, with rate proportional to q^2.  NaN if u is defective.
    std::complex<double> damping;
    /// Indexed as Symbol; norm 1 after each field is divided by its unit.
    Eigen::Matrix<std::complex<double>, FieldIndex::count, 1> shape;
};

/// Reduced equations of the slow modes after elimination of the fast ones: rates = (-i q U + q^2 D) slow, with
/// U = U_x c + U_y s and D of second degree in c and s, the cosine and sine of the angle of q.  There is one slow mode
/// for each conserved density, one for the free direction of a flock, and two for the momentum of beads without drag.
struct LongWaves {
    using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, FieldIndex::count, FieldIndex::count>;
    Small speed_x, speed_y;                    ///< U
    Small damping_xx, damping_yy, damping_xy;  ///< -D = D_xx c^2 + D_yy s^2 + D_xy c s
    Small left;             ///< duals of `right`, one per row: project a forcing of the fields on the slow modes
    Small right;            ///< slow modes, one per column, indexed as Symbol
    std::string undefined;  ///< why the expansion does not exist (a fast mode has become slow); empty if it exists
};

/// Source: second-order perturbation of a semi-simple eigenvalue (Kato, Perturbation Theory for Linear Operators,
/// II.2), for M d/dt = F(q): M is the mass matrix, F the sum of the linearisations, of second degree in q.
LongWaves long_waves(const Equations& equations, const StationaryState& about);

/// Slow modes of waves at an angle to the x axis [rad], ordered by speed.
std::vector<SlowMode> slow_modes(const LongWaves& waves, double angle);

/// Growth of the fastest slow mode: proportional to q (first = Im u > 0), else to q^2 (first = 0, second = -gamma).
struct SlowGrowth {
    double first = 0.0, second = 0.0;
    /// Positive if every slow mode decays.  Its unit is [mm/s] or [mm^2/s]; only its sign is meaningful.
    double margin() const { return first > 0.0 ? -first : -second; }
};
SlowGrowth slow_growth(const LongWaves& waves, double angle);

}  // namespace drover::physics
