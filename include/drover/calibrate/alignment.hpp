// calibrate/alignment.hpp: mean-field theory of rods that align with the flow they drive.
#pragma once

namespace drover::calibrate {

/// Polar order P of rods in their own flow: P = I1(gP)/I0(gP), g = lambda_s alpha/(Gamma D_r); 0 for g <= 2.
/// Source: the stationary distribution f ~ exp(g P cos theta) of rods with rotational diffusion (standard mean field).
double order_of_alignment(double alignment);

/// b/D_r for p = P: (g/2 - 1)/P^2, which solves a - lambda alpha/Gamma + b P^2 = 0 at that P.
/// At and below onset its limit g^2/8.
double saturation_of_alignment(double alignment);

}  // namespace drover::calibrate
