// measure/rotational_diffusion.cpp: the autocorrelation of directions, and the diffusion it shows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/base/error.hpp"
#include "drover/measure/trajectories.hpp"
#include "measure/independent_units.hpp"

namespace drover::measure {

namespace {

constexpr double from_beside_to = 8.0;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Line y = at_zero + slope t by least squares, weights 1/t^2.
struct Line {
    double at_zero = 0.0, slope = 0.0;
};
Line fit_line(std::span<const double> t, std::span<const double> y) {
    double weight = 0.0, mean_t = 0.0, mean_y = 0.0, tt = 0.0, ty = 0.0;
    for (std::size_t i = 0; i < t.size(); ++i) weight += 1.0 / (t[i] * t[i]);
    for (std::size_t i = 0; i < t.size(); ++i) {
        mean_t += t[i] / (t[i] * t[i] * weight);
        mean_y += y[i] / (t[i] * t[i] * weight);
    }
    for (std::size_t i = 0; i < t.size(); ++i) {
        tt += (t[i] - mean_t) * (t[i] - mean_t) / (t[i] * t[i]);
        ty += (t[i] - mean_t) * (y[i] - mean_y) / (t[i] * t[i]);
    }
    return {mean_y - ty / tt * mean_t, ty / tt};
}

/// Lags to fit, first and one beyond the last.
struct Lags {
    std::size_t first = 1, end = 1;
};
Lags lags_to_fit(const RotationalCorrelation& correlation, const std::vector<double>& whole, const RotationFit& fit) {
    const std::vector<double>& times = correlation.times;
    Lags lags;
    if (times.size() < 2) return lags;
    const double close = 1e-9 * times[1];
    const auto lasts = [&](std::size_t lag) {
        if (!(whole[lag] > 0.0)) return false;
        return fit.to > 0.0 ? times[lag] <= fit.to + close : -std::log(whole[lag]) <= fit.drop;
    };
    while (lags.end < times.size() && lasts(lags.end)) ++lags.end;
    const double from = fit.from > 0.0 ? fit.from : times[lags.end - 1] / from_beside_to;
    while (lags.first < lags.end && times[lags.first] < from - close) ++lags.first;
    return lags;
}

}  // namespace

RotationalCorrelation rotational_correlation(std::span<const std::vector<double>> angles, double spacing,
                                             std::size_t max_lags) {
    require(spacing > 0.0 && std::isfinite(spacing), {}, "angles {} s apart; expected a positive time", spacing);
    std::size_t longest = 0;
    for (const std::vector<double>& path : angles) longest = std::max(longest, path.size());
    const std::size_t lags = std::min(max_lags + 1, longest), stretches = stretches_of(angles.size());
    UnitSums units(angles.size() * stretches, lags);
    RotationalCorrelation result{.by_time = stretches > 1};
    for (std::size_t rod = 0; rod < angles.size(); ++rod) {
        const std::size_t size = angles[rod].size();
        std::vector<double> x(size), y(size);
        for (std::size_t i = 0; i < size; ++i) {
            x[i] = std::cos(angles[rod][i]);
            y[i] = std::sin(angles[rod][i]);
        }
        for (std::size_t i = 0; i < size; ++i) {
            const std::size_t unit = rod * stretches + stretch_of(i, size, stretches);
            for (std::size_t lag = 0; lag < lags && i + lag < size; ++lag)
                units.add(unit, lag, x[i] * x[i + lag] + y[i] * y[i + lag]);
        }
        const double time = static_cast<double>(size / stretches) * spacing;
        result.unit_time = rod == 0 ? time : std::min(result.unit_time, time);
    }
    for (std::size_t lag = 0; lag < lags; ++lag) result.times.push_back(static_cast<double>(lag) * spacing);
    result.values = estimate_each(units.sums, units.counts);
    result.sums = std::move(units.sums);
    result.counts = std::move(units.counts);
    return result;
}

Estimate relaxation_time_of(const Estimate& diffusion) {
    const double rate = diffusion.mean;
    if (std::isnan(rate)) return diffusion;
    if (!(rate > 0.0))
        return {.mean = std::numeric_limits<double>::infinity(), .refusal = "error refused: C(t) does not fall"};
    Estimate time = diffusion;
    time.mean = 1.0 / rate;
    if (diffusion.error) time.error = *diffusion.error / (rate * rate);
    return time;
}

RotationalDiffusion rotational_diffusion(const RotationalCorrelation& correlation, const RotationFit& fit) {
    RotationalDiffusion result;
    std::vector<double> whole(correlation.times.size()), weight(whole.size());
    for (std::size_t u = 0; u < correlation.sums.size(); ++u)
        for (std::size_t lag = 0; lag < whole.size(); ++lag) {
            whole[lag] += correlation.sums[u][lag];
            weight[lag] += correlation.counts[u][lag];
        }
    for (std::size_t lag = 0; lag < whole.size(); ++lag) whole[lag] /= weight[lag];
    const Lags lags = lags_to_fit(correlation, whole, fit);
    result.lags = lags.end - lags.first;
    if (result.lags < 2) {
        result.diffusion = {.mean = not_a_number,
                            .refusal = text("{} lags to fit; expected two or more before -ln C(t) passes {}: sample "
                                            "more often, or follow for longer",
                                            result.lags, fit.drop)};
        result.relaxation_time = result.diffusion;
        return result;
    }
    const std::span<const double> times = std::span(correlation.times).subspan(lags.first, result.lags);
    const auto line = [&](std::span<const double> means) {
        std::vector<double> y;
        for (const double mean : means.subspan(lags.first, result.lags)) y.push_back(-std::log(mean));
        return fit_line(times, y);
    };
    result.diffusion =
        estimate_units(correlation.sums, correlation.counts, [&](auto means) { return line(means).slope; });
    result.fast = -std::expm1(-line(whole).at_zero);
    result.from = times.front();
    result.to = times.back();
    const double rate = result.diffusion.mean;
    if (correlation.by_time && result.diffusion.error && rate * correlation.unit_time < 3.0) {
        result.diffusion.error.reset();
        result.diffusion.refusal = text(
            "error refused: stretches of {} s are less than three relaxation times of {} s; follow for longer, or "
            "{} rods or more",
            correlation.unit_time, 1.0 / rate, min_units);
    }
    result.relaxation_time = relaxation_time_of(result.diffusion);
    return result;
}

}  // namespace drover::measure
