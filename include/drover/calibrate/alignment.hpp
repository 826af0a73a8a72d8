// calibrate/alignment.hpp: the mean field of rods that turn into the flow that they make.
#pragma once

namespace drover::calibrate {

/// P of rods in the flow that they make: P = I1(gP)/I0(gP), g = lambda_s alpha/(Gamma D_r); 0 up to g = 2.
/// Source: the stationary f ~ exp(g P cos theta) of rods with rotational diffusion, as for any such mean field.
double order_of_alignment(double alignment);

/// b/D_r for p = P: (g/2 - 1)/P^2, which makes a - lambda alpha/Gamma + b P^2 = 0 at that P; g^2/8 at and below onset, its limit.
double saturation_of_alignment(double alignment);

}  // namespace drover::calibrate
