// numerics/algebra/bracket.hpp: the location of a sign change between two points, and the end of a band.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/constants.hpp"

namespace drover::numerics {

/// Zero counts as positive, NaN as neither.
inline bool is_positive(double value) { return value >= 0.0; }
inline bool is_opposite(double a, double b) {
    return !std::isnan(a) && !std::isnan(b) && is_positive(a) != is_positive(b);
}

/// Where in [0, 1] f(t) changes sign, within `tolerance`, given f at 0, 1/2 and 1 with opposite signs at the ends:
/// inverse quadratic interpolation where it can be trusted (Chandrupatla, Adv. Eng. Software 28, 145 (1997)), else
/// bisection, so that jumps and infinite values do no harm.  NaN when any evaluation is; `calls` is
/// increased by the number of evaluations.
template <class Function>
double sign_change(const Function& f, double at_0, double at_half, double at_1, double tolerance, std::size_t& calls) {
    constexpr int trusted = 40;  // steps after which only bisection is used
    double a = 0.5, b = is_opposite(at_half, at_0) ? 0.0 : 1.0, c = 1.0 - b;
    double fa = at_half, fb = b == 0.0 ? at_0 : at_1, fc = b == 0.0 ? at_1 : at_0;
    for (int step = 0; !std::isnan(fa); ++step) {
        const double width = std::abs(b - a);
        if (width <= tolerance)
            return std::abs(fa) <= std::abs(fb) ? a : b;  // the nearer end; an exact zero may be one of many
        const double xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
        double part = 0.5;
        if (step < trusted && 1.0 - std::sqrt(1.0 - xi) < phi && phi < std::sqrt(xi)) {
            part = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb);
            const double min_part = 0.5 * tolerance / width;
            part = part > min_part ? (part < 1.0 - min_part ? part : 1.0 - min_part) : min_part;
        }
        const double t = a + part * (b - a), value = f(t);
        ++calls;
        if (is_opposite(value, fa)) {
            c = b, fc = fb, b = a, fb = fa;
        } else {
            c = a, fc = fa;
        }
        a = t, fa = value;
    }
    return fa;
}

/// Where `value` becomes or ceases to be above 0 between two places, to a part `precision` of them.
template <class Value>
double crossing(double low, double high, double precision, Value value) {
    constexpr double least = std::numeric_limits<double>::min();
    const auto at = [&](double part) {
        const double here = value(low + part * (high - low));
        return here > 0.0 ? here : -std::max(least, -here);
    };
    std::size_t calls = 0;
    constexpr double least_part = 4.0 * std::numeric_limits<double>::epsilon();
    const double tolerance = std::max(least_part, precision * (1.0 + std::abs(low)) / (high - low));
    return low + (high - low) * sign_change(at, at(0.0), at(0.5), at(1.0), tolerance, calls);
}

}  // namespace drover::numerics
