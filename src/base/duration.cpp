// base/duration.cpp: durations from their texts.
#include "base/duration.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "drover/base/error.hpp"

namespace drover {

namespace {
/// "1.5h" or "90"; 0 for another text.
double seconds_with_unit(const std::string& duration) {
    double value = 0.0;
    const char* const last = duration.data() + duration.size();
    const auto [end, problem] = std::from_chars(duration.data(), last, value);
    std::string unit(end, last);
    std::erase(unit, ' ');
    const double seconds = unit == "s" || unit.empty()    ? 1.0
                           : unit == "min" || unit == "m" ? 60.0
                           : unit == "h"                  ? 3600.0
                                                          : 0.0;
    return problem == std::errc() ? value * seconds : 0.0;
}

/// "mm:ss", "hh:mm:ss" or "d-hh:mm:ss"; 0 for another text.
double seconds_of_clock(const std::string& duration) {
    std::vector<unsigned> parts;
    std::string separators;
    const char* const last = duration.data() + duration.size();
    for (const char* at = duration.data();; ++at) {
        unsigned value = 0;  // has no sign
        const auto [end, problem] = std::from_chars(at, last, value);
        if (problem != std::errc()) return 0.0;
        parts.push_back(value);
        if (end == last) break;
        separators += *end;
        at = end;
    }
    if (separators != ":" && separators != "::" && separators != "-::") return 0.0;
    constexpr std::array units{86400.0, 3600.0, 60.0, 1.0};
    constexpr std::array limits{0u, 24u, 60u, 60u};  // but for the first part
    double seconds = 0.0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::size_t unit = units.size() - parts.size() + i;
        if (i > 0 && parts[i] >= limits[unit]) return 0.0;
        seconds += parts[i] * units[unit];
    }
    return seconds;
}
}  // namespace

double seconds_of(const std::string& duration, const std::string& option) {
    const bool is_clock = duration.find(':') != std::string::npos;
    const double seconds = is_clock ? seconds_of_clock(duration) : seconds_with_unit(duration);
    require(seconds > 0.0 && std::isfinite(seconds), {.file = option},
            "\"{}\" is not a duration; expected a number above 0 with s, min or h, such as 20min, or hh:mm:ss",
            duration);
    return seconds;
}

}  // namespace drover
