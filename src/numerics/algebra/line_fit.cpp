// numerics/algebra/line_fit.cpp: a straight line by weighted least squares, by GSL.
#include "numerics/algebra/line_fit.hpp"

#include <gsl/gsl_fit.h>

namespace drover::numerics {

Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights) {
    Line line;
    double covariance[3], chi_square = 0.0;
    gsl_fit_wlinear(x.data(), 1, weights.data(), 1, y.data(), 1, x.size(), &line.at_zero, &line.slope, &covariance[0],
                    &covariance[1], &covariance[2], &chi_square);
    return line;
}

}  // namespace drover::numerics
