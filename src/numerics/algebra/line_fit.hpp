// numerics/algebra/line_fit.hpp: a straight line by weighted least squares.
#pragma once
#include <span>

namespace drover::numerics {

/// y = at_zero + slope x.
struct Line {
    double at_zero = 0.0, slope = 0.0;
};

/// The line that minimises sum weights (y - at_zero - slope x)^2; points with weight 0 are ignored.  NaN where the
/// line is not unique.  x, y and weights have the same length.
Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights);

}  // namespace drover::numerics
