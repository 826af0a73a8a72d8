// base/duration.hpp: wall time, and durations that a user gives.
#pragma once
#include <chrono>
#include <string>

namespace drover {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The seconds of "3600", "90s", "90m" or "90min", "1.5h", "mm:ss", "hh:mm:ss" or "d-hh:mm:ss".  Throws an input Error,
/// which names the option, for another text.
double seconds_of(const std::string& duration, const std::string& option);

}  // namespace drover
