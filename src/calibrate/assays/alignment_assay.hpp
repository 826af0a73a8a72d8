// calibrate/assays/alignment_assay.hpp: alignment of rods by contacts, without the flow that they drive.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Fields and times of a trial.
struct AlignmentPlan {
    /// Of the orienting field, ascending [mg mm^2/s^2] > 0; for P from below .4 to .9.
    std::vector<double> torques = {100.0, 300.0, 1000.0};
    double warm_up = 0.5;  ///< once, without a field [s]
    double time = 4.0;     ///< in each field [s]
    int windows = 2;       ///< of equal length in that time
    double frame = 0.025;  ///< between samples of P [s]

    static Rows<AlignmentPlan> rows();
};

/// Rate of relaxation at which c sigma is also reported [1/s].
inline constexpr double reference_rate = 0.1;

/// Alignment of rods by contacts at the area fractions of the setup: many rods, in random directions at first, in an
/// orienting field along x that grows, while the mean velocity of the beads, if any, is held at zero.  Rods that turn
/// with the torque mu T and, by contacts, 2 c sigma P towards the mean orientation P of all, obey
///     d_t <P_x> = -a <P_x> + (mu T/2) <1 - C2> + c sigma <P_x (1 - C2) - P_y S2>,
/// C2 and S2 being the means of cos and sin of twice the angle.  It is exact for any number of rods, any distribution
/// and any history, and linear in a, mu and c sigma: least squares over the windows of all fields.  The fit of all
/// three gives the rate a among rods; with a of the relaxation assay, c sigma = contact_steady + a contact_slope.  (The
/// saturation b follows from a and c, as from any alignment.)
/// Quantities: contact_reference, c sigma at a = 0.1/s, whose error also tells the covariance of contact_steady [1/s]
/// and contact_slope [1]; relaxation_among_rods a [1/s]; orienting_mobility mu [s/(mg mm^2)], at a = 0.1/s;
/// order_held_<T>, <P> in the last window of each field.
/// Source: first moment of the Langevin equation of rods with pairwise torques (2 c/V) sin(theta_j - theta_i).
Assay alignment(const AlignmentPlan& plan = {});

}  // namespace drover::calibrate
