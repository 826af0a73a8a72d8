// dem/impact/closing_time.hpp: when a gap between two surfaces closes.
#pragma once
#include <algorithm>
#include <cmath>

namespace drover::dem {

inline constexpr double never = 1e300;

/// First t >= 0 at which the gap g + v t + a t^2/2 closes: 0 if it is closed and closing, `never` if it stays open.
inline double closing_time(double g, double v, double a) {
    if (g <= 0.0 && v < 0.0) return 0.0;
    const double d = v * v - 2.0 * g * a;
    if (a < 0.0) return d > 0.0 ? std::max(0.0, (v + std::sqrt(d)) / -a) : v / -a;
    if (v >= 0.0 || d < 0.0) return never;
    return 2.0 * g / (-v + std::sqrt(d));
}

}  // namespace drover::dem
