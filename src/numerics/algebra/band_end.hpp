// numerics/algebra/band_end.hpp: where a band of values between -1 and 1 ends along sampled places.
#pragma once
#include <cmath>
#include <limits>

namespace drover::numerics {

/// From a place with this value on, over the samples first, first + step, ... of 0 to count - 1, at place(i) with the
/// values value(i): where the linear interpolation passes -1 or 1.  NaN if it does not, or if a value is NaN.
template <class Place, class Value>
double band_end(double from, double value_there, int first, int step, int count, Place place, Value value) {
    constexpr double no_end = std::numeric_limits<double>::quiet_NaN();
    if (!(std::abs(value_there) <= 1.0)) return no_end;
    double before = from, at_before = value_there;
    for (int i = first; i >= 0 && i < count; i += step) {
        const double here = place(i), at_here = value(i);
        if (std::isnan(at_here)) return no_end;
        if (std::abs(at_here) > 1.0)
            return before + (here - before) * (std::copysign(1.0, at_here) - at_before) / (at_here - at_before);
        before = here, at_before = at_here;
    }
    return no_end;
}

}  // namespace drover::numerics
