// calibrate/alignment.cpp: the mean field of rods that turn into the flow that they make.
#include "drover/calibrate/alignment.hpp"

#include <cmath>

namespace drover::calibrate {

double order_of_alignment(double alignment) {
    if (!(alignment > 2.0)) return 0.0;
    // x = gP solves I1(x)/I0(x) = x/g, whose left side is concave: one root above 0.
    const auto excess = [&](double x) {
        // Beyond some hundreds the functions leave the range of numbers; the terms of the series that are left out are below 1e-10 there.
        constexpr double large = 500.0;
        const double ratio = x < large ? std::cyl_bessel_i(1.0, x) / std::cyl_bessel_i(0.0, x)
                                       : 1.0 - 0.5 / x - 0.125 / (x * x) - 0.125 / (x * x * x);
        return ratio - x / alignment;
    };
    double low = 0.0, high = alignment;
    constexpr int halvings = 100;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (excess(middle) > 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high) / alignment;
}

double saturation_of_alignment(double alignment) {
    // Nearer than this P^2 = (g - 2)(1 - 5/6 (g - 2)) loses its digits; the limit is off by as little.
    constexpr double near = 1e-6;
    if (alignment < 2.0 + near) return 0.125 * alignment * alignment;
    const double order = order_of_alignment(alignment);
    return (0.5 * alignment - 1.0) / (order * order);
}

}  // namespace drover::calibrate
