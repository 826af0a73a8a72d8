// physics/long_waves.hpp: the slow modes of a uniform state at long waves: speeds and dampings by angle, exact in q ->
// 0.
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
    std::complex<double> speed;  ///< u [mm/s]; an imaginary part above 0 grows as q
    std::complex<double>
        damping;  ///< gamma [mm^2/s]; a real part below 0 grows as q^2.  Not-a-number at a defective u.
    Eigen::Matrix<std::complex<double>, FieldIndex::count, 1>
        shape;  ///< as in Symbol, of length 1 after each field is divided by its unit
};

/// What rules the slow modes, the fast ones being eliminated: rates = (-i q U + q^2 D) slow, with U = U_x c + U_y s
/// and D likewise of second degree, c and s cosine and sine of the angle of q.  As many slow modes as the state has
/// conserved densities, one more for the free direction of a flock, two for the momentum of beads that nothing holds
/// back.
struct LongWaves {
    using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, FieldIndex::count, FieldIndex::count>;
    Small speed_x, speed_y;                    ///< U
    Small damping_xx, damping_yy, damping_xy;  ///< -D = D_xx c^2 + D_yy s^2 + D_xy c s
    Small left;             ///< its duals, a row each: what a push on the fields does to the slow modes
    Small right;            ///< slow fields in the places of a Symbol, a column each
    std::string undefined;  ///< why there is no such expansion (a fast mode has become slow); empty: there is
};

/// Source: second-order perturbation of a semi-simple eigenvalue (Kato, Perturbation Theory for Linear Operators,
/// II.2), for moved d/dt = F(q), F the sum of the terms' linearisations, which is of second degree in q.
LongWaves long_waves(const Equations& equations, const StationaryState& about);

/// Slow modes of waves at an angle to the x axis [rad], ordered by speed.
std::vector<SlowMode> slow_modes(const LongWaves& waves, double angle);

/// How fast the fastest slow mode grows: as q (first, > 0: Im u), else as q^2 (then first = 0 and second = -gamma).
struct SlowGrowth {
    double first = 0.0, second = 0.0;
    /// > 0: every slow mode decays.  Of either kind, [mm/s] or [mm^2/s]: its sign is what counts.
    double margin() const { return first > 0.0 ? -first : -second; }
};
SlowGrowth slow_growth(const LongWaves& waves, double angle);

}  // namespace drover::physics
