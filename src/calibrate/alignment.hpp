// calibrate/alignment.hpp: mean-field theory of rods that align with their mean orientation, few or many.
#pragma once

namespace drover::calibrate {

/// Polar order P of rods in their own flow and contacts: P = I1(x)/I0(x), x = g P + g3 P^3, the largest P if there are
/// several.  g = (lambda_s alpha/Gamma + 2 c sigma)/D_r, g3 = lambda_s alpha_3/(Gamma D_r) where the flow is not linear
/// in the order.  0 for g <= 2, unless a large g3 keeps an order that is there.
/// Source: the stationary distribution f ~ exp(x cos theta) of rods with rotational diffusion (standard mean field).
double order_of_alignment(double alignment, double cubic = 0.0);

/// b/D_r for p = P: (g/2 - 1)/P^2 + g3/2, which solves a - c sigma - lambda (alpha + alpha_3 P^2)/Gamma + b P^2 = 0 at
/// that P.  At and below onset its limit g^2/8, or g3/2 if larger, so that no fluctuation grows: an order that a strong
/// g3 keeps at g <= 2 is none of the equations.
double saturation_of_alignment(double alignment, double cubic = 0.0);

/// kappa such that I1(kappa)/I0(kappa) is this order, -1 < P < 1: what holds independent rods at that order.
double concentration_of_order(double order);

/// 1/a at which the drag assay also reports the alignment, since its error contains the covariance of its parts [s].
inline constexpr double reference_time = 10.0;
/// a at which the alignment assay also reports c sigma, for the same reason [1/s].
inline constexpr double reference_rate = 0.1;

/// Order of finitely many rods.
struct RodsOrder {
    double mean = 0.0;       ///< <|P|>
    double deviation = 0.0;  ///< standard deviation of |P|
};

/// N rods with the weight exp(g N P^2/2 + g3 N P^4/4) on their directions: each turns as if all others held it, which
/// is the mean field above for N -> infinity.  Without alignment <|P|> is about sqrt(pi/N)/2.  The density of the mean
/// of N unit vectors is that of a saddle point, normalised (0.4 % of <|P|> at N = 25).
/// Source: the stationary distribution of that weight; H. E. Daniels, Ann. Math. Stat. 25, 631 (1954).
RodsOrder order_of_rods(int rods, double alignment, double cubic = 0.0);

}  // namespace drover::calibrate
