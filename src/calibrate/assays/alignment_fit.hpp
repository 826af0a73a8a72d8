// calibrate/assays/alignment_fit.hpp: alignment of rods from their order in fields of several strengths.
#pragma once
#include <span>
#include <vector>

namespace drover::calibrate {

/// Mean order along the field in consecutive windows of equal length.
struct OrderInField {
    double torque = 0.0;         ///< [mg mm^2/s^2]
    std::vector<double> orders;  ///< of each window, in time
};

/// Rods of concentration kappa = I1/I0^-1(P) whose alignment g and field hold them elsewhere relax as
///     kappa (1 + d_t P/(a P)) = g P + beta T,
/// the equation for the mean of exp(i theta) with its second harmonic closed by a von Mises distribution; exact in a
/// steady state and for many rods.  Midpoints of neighbouring windows, weighted by dP/dkappa (errors of P are equal).
/// The rate a is not fitted: noise of d_t P would bias it, and with it g.
struct AlignmentFit {
    double alignment = 0.0;  ///< g
    double response = 0.0;   ///< beta [1/(mg mm^2/s^2)]
};

/// The fit as a function of the rate: steady + drift/a.
struct LinearAlignmentFit {
    AlignmentFit steady;  ///< with d_t P left out
    AlignmentFit drift;   ///< its derivative by 1/a [1/s]
};
/// 1/a at which assays also report the fit, since its error contains the covariance of steady and drift [s].
inline constexpr double reference_time = 10.0;

LinearAlignmentFit fit_alignment(std::span<const OrderInField> fields, double window);

}  // namespace drover::calibrate
