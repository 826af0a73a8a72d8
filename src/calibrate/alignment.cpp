// calibrate/alignment.cpp: mean-field theory of rods that align with the flow they drive.
#include "drover/calibrate/alignment.hpp"

#include <cmath>

namespace drover::calibrate {

double order_of_alignment(double alignment) {
    if (!(alignment > 2.0)) return 0.0;
    // x = gP solves I1(x)/I0(x) = x/g; the left side is concave, so there is one positive root.
    const auto excess = [&](double x) {
        // The Bessel functions overflow beyond several hundred; the omitted terms of the series are below 1e-10 there.
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
    // Closer to onset P^2 = (g - 2)(1 - 5/6 (g - 2)) suffers from cancellation; the limit is as accurate there.
    constexpr double near = 1e-6;
    if (alignment < 2.0 + near) return 0.125 * alignment * alignment;
    const double order = order_of_alignment(alignment);
    return (0.5 * alignment - 1.0) / (order * order);
}

}  // namespace drover::calibrate
