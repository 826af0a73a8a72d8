// base/constants.hpp: numbers that many sources need.
#pragma once
#include <limits>
#include <numbers>

namespace drover {

inline constexpr double infinite = std::numeric_limits<double>::infinity();
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double right_angle = std::numbers::pi / 2.0;
inline constexpr double radians_per_degree = std::numbers::pi / 180.0;

}  // namespace drover
