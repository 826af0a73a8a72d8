// base/draws.cpp: draws of uncertain numbers, and quantiles of what follows from them.
#include "base/draws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/constants.hpp"
#include "drover/base/random.hpp"

namespace drover {

namespace {
/// The standard normal number below which this part lies.
double normal_quantile(double part) {
    double low = -40.0, high = 40.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(-middle / std::numbers::sqrt2) < part ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// The middles of this many equally probable parts, ascending.  Kept, since a table has many numbers of as many draws.
const std::vector<double>& middles_of_parts(std::size_t count) {
    thread_local std::vector<double> middles;
    if (middles.size() != count) {
        middles.resize(count);
        for (std::size_t k = 0; k < count; ++k)
            middles[k] = normal_quantile((static_cast<double>(k) + 0.5) / static_cast<double>(count));
    }
    return middles;
}
}  // namespace

std::vector<double> ranks_of(std::span<const double> values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    std::vector<double> ranks(values.size());
    for (std::size_t k = 0; k < order.size(); ++k) ranks[order[k]] = static_cast<double>(k);
    return ranks;
}

std::vector<double> random_ranks(std::uint64_t number, std::uint64_t part, std::size_t count) {
    std::vector<double> keys(count);
    fill_uniform({.stream = Stream::uncertainty, .step = number, .substep = part}, 0, 1, keys);
    return ranks_of(keys);
}

std::vector<double> normal_draws(std::span<const double> order) {
    std::vector<double> draws = ranks_of(order);
    const std::vector<double>& middles = middles_of_parts(order.size());
    for (double& one : draws) one = middles[static_cast<std::size_t>(one)];
    return draws;
}

std::uint64_t number_of_name(const std::string& name) {
    std::uint64_t number = 14695981039346656037u;
    for (const char letter : name) number = (number ^ static_cast<unsigned char>(letter)) * 1099511628211u;
    return number;
}

double quantile(const std::vector<double>& values, double part) {
    const double last = static_cast<double>(values.size() - 1),
                 place = std::clamp(part * static_cast<double>(values.size()) - 0.5, 0.0, last);
    const auto below = static_cast<std::size_t>(place);
    const double low = values[below], high = values[std::min(below + 1, values.size() - 1)],
                 above = place - static_cast<double>(below);
    if (std::isfinite(low) && std::isfinite(high)) return low + above * (high - low);
    return above < 0.5 ? low : high;
}

double half_width(std::vector<double> values) {
    std::erase_if(values, [](double value) { return std::isnan(value); });
    if (values.empty()) return nan;
    std::ranges::sort(values);
    return 0.5 * (quantile(values, 1.0 - below_one_sigma) - quantile(values, below_one_sigma));
}

double over_error(const std::vector<double>& values) {
    const auto count = static_cast<double>(values.size());
    const auto below = static_cast<double>(std::ranges::lower_bound(values, 0.0) - values.begin());
    if (below > 0.0 && below < count) return -normal_quantile(below / count);
    constexpr double far = 1e9;  // where no number with an error matters
    const double low = quantile(values, below_one_sigma), high = quantile(values, 1.0 - below_one_sigma),
                 nearest = -normal_quantile(0.5 / count), ratio = std::abs(low + high) / (high - low);
    return std::copysign(std::isnan(ratio) ? nearest : std::clamp(ratio, nearest, far), below > 0.0 ? -1.0 : 1.0);
}

}  // namespace drover
