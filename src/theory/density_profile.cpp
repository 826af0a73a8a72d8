// theory/density_profile.cpp: the plateaus of a density.
#include "theory/density_profile.hpp"
#include "base/constants.hpp"

#include <algorithm>
#include <cmath>

namespace drover::theory {

namespace {
/// The part of a periodic line above a value, with straight lines between its points.
double share_above(std::span<const double> values, double middle) {
    double points = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double here = values[i] - middle, next = values[(i + 1) % values.size()] - middle;
        if (here > 0.0 && next > 0.0) points += 1.0;
        else if (here > 0.0 || next > 0.0) points += std::max(here, next) / std::abs(here - next);
    }
    return points / static_cast<double>(values.size());
}
}  // namespace

DensityProfile density_profile(std::span<const double> density, double lx) {
    const auto [min, max] = std::ranges::minmax_element(density);
    const double middle = 0.5 * (*min + *max), range = *max - *min;
    constexpr double rounding = 1e-12;
    if (range <= rounding * std::abs(middle)) return {.low = middle, .high = middle};  // uniform
    const std::size_t n = density.size();
    const auto above = static_cast<std::size_t>(std::ranges::count_if(density, [&](double d) { return d > middle; }));
    DensityProfile profile{.width = lx * share_above(density, middle)};
    constexpr double flat = 1e-3;  // of the range, over a quarter of the part
    const auto flattest = [&](bool is_high, std::size_t& place, bool& is_flat) {
        const std::size_t reach = (is_high ? above : n - above) / 8;
        double smallest = infinite;
        for (std::size_t i = 0; i < n; ++i) {
            if ((density[i] > middle) != is_high) continue;
            double deviation = 0.0;
            for (std::size_t k = n - reach; k <= n + reach; ++k)
                deviation = std::max(deviation, std::abs(density[(i + k) % n] - density[i]));
            if (deviation >= smallest) continue;
            smallest = deviation;
            place = i;
        }
        is_flat = reach > 1 && smallest < flat * range;
    };
    flattest(false, profile.low_at, profile.low_is_flat);
    flattest(true, profile.high_at, profile.high_is_flat);
    profile.low = density[profile.low_at];
    profile.high = density[profile.high_at];
    return profile;
}

}  // namespace drover::theory
