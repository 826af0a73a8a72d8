// measure/trajectories.cpp: speeds along rods; autocorrelation of directions, and rotational diffusion from it.
#include "measure/trajectories.hpp"

#include <algorithm>
#include <cmath>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "numerics/algebra/extremum.hpp"

namespace drover::measure {

Estimate with_error_over_time(const GroupSums& groups, const Samples& samples) {
    Estimate over_time = estimate_mean(samples, 0);
    if (groups.sums.size() < 2) return over_time;
    Estimate over_bodies = jackknife_means(groups).front();
    if (!over_bodies.error || (over_time.error && *over_time.error > *over_bodies.error)) {
        over_time.mean = over_bodies.mean;
        return over_time;
    }
    return over_bodies;
}

namespace {
/// Means over their own errors; NaN with fewer than four that have one.
double scatter_of(const std::vector<Estimate>& means) {
    constexpr std::size_t min_count = 4;
    double weights = 0.0, sum = 0.0, squares = 0.0;
    std::size_t count = 0;
    for (const Estimate& one : means)
        if (one.error && *one.error > 0.0) {
            const double weight = 1.0 / (*one.error * *one.error);
            weights += weight;
            sum += weight * one.mean;
            ++count;
        }
    for (const Estimate& one : means)
        if (one.error && *one.error > 0.0) squares += std::pow((one.mean - sum / weights) / *one.error, 2);
    return count < min_count ? nan : std::sqrt(squares / (static_cast<double>(count) - 1.0));
}

constexpr double range_of_lags = 8.0;  // largest over smallest lag of a fit

/// Lags to fit, first and one beyond the last.
struct Lags {
    std::size_t first = 1, end = 1;
};
Lags lags_to_fit(const RotationalCorrelation& correlation, const std::vector<double>& means, const RotationFit& fit) {
    const std::vector<double>& times = correlation.times;
    Lags lags;
    if (times.size() < 2) return lags;
    const double close = 1e-9 * times[1];
    const auto is_fitted = [&](std::size_t lag) {
        if (!(means[lag] > 0.0)) return false;
        return fit.to > 0.0 ? times[lag] <= fit.to + close : -std::log(means[lag]) <= fit.drop;
    };
    while (lags.end < times.size() && is_fitted(lags.end)) ++lags.end;
    const double from = fit.from > 0.0 ? fit.from : times[lags.end - 1] / range_of_lags;
    while (lags.first < lags.end && times[lags.first] < from - close) ++lags.first;
    return lags;
}
}  // namespace

Speeds speeds_along(std::span<const Path> rods, std::span<const std::vector<double>> angles, double spacing) {
    require(spacing > 0.0, {}, "frames {} s apart; expected a positive time", spacing);
    require(rods.size() == angles.size(), {}, "{} paths and angles of {} rods; expected equal numbers", rods.size(),
            angles.size());
    Speeds result;
    GroupSums groups(rods.size(), 1);
    std::vector<double> of_frames, rods_in_frame;  // the mean over rods
    std::vector<Estimate> over_time;
    for (std::size_t r = 0; r < rods.size(); ++r) {
        const Path& rod = rods[r];
        require(rod.x.size() == angles[r].size() && rod.y.size() == angles[r].size(), {},
                "rod {}: {} positions and {} angles; expected equal numbers", r, rod.x.size(), angles[r].size());
        const std::size_t frames = angles[r].empty() ? 0 : angles[r].size() - 1;
        of_frames.resize(std::max(of_frames.size(), frames));
        rods_in_frame.resize(of_frames.size());
        std::vector<double> speeds;
        for (std::size_t i = 0; i < frames; ++i) {
            const double vx = (rod.x[i + 1] - rod.x[i]) / spacing, vy = (rod.y[i + 1] - rod.y[i]) / spacing;
            const double speed = vx * std::cos(angles[r][i]) + vy * std::sin(angles[r][i]);
            groups.add(r, 0, speed);
            speeds.push_back(speed);
            of_frames[i] += (speed - of_frames[i]) / ++rods_in_frame[i];
        }
        if (frames > 0) result.of_rods.push_back(groups.sums[r][0] / groups.counts[r][0]);
        over_time.push_back(estimate_mean({.series = {std::move(speeds)}, .spacing = spacing}, 0));
    }
    result.scatter = scatter_of(over_time);
    if (!of_frames.empty()) result.mean = with_error_over_time(groups, {.series = {of_frames}, .spacing = spacing});
    return result;
}

RotationalCorrelation rotational_correlation(std::span<const std::vector<double>> angles, double spacing,
                                             std::size_t max_lags) {
    require(spacing > 0.0 && std::isfinite(spacing), {}, "angles {} s apart; expected a positive time", spacing);
    std::size_t longest = 0;
    for (const std::vector<double>& path : angles) longest = std::max(longest, path.size());
    const std::size_t lags = std::min(max_lags + 1, longest), segments = segments_per_body(angles.size());
    RotationalCorrelation result{.groups = GroupSums(angles.size() * segments, lags), .by_time = segments > 1};
    for (std::size_t rod = 0; rod < angles.size(); ++rod) {
        const std::size_t size = angles[rod].size();
        std::vector<double> x(size), y(size);
        for (std::size_t i = 0; i < size; ++i) {
            x[i] = std::cos(angles[rod][i]);
            y[i] = std::sin(angles[rod][i]);
        }
        for (std::size_t i = 0; i < size; ++i) {
            const std::size_t group = rod * segments + segment_of(i, size, segments);
            for (std::size_t lag = 0; lag < lags && i + lag < size; ++lag)
                result.groups.add(group, lag, x[i] * x[i + lag] + y[i] * y[i + lag]);
        }
        const double time = static_cast<double>(size / segments) * spacing;
        result.segment_time = rod == 0 ? time : std::min(result.segment_time, time);
    }
    for (std::size_t lag = 0; lag < lags; ++lag) result.times.push_back(static_cast<double>(lag) * spacing);
    result.values = jackknife_means(result.groups);
    return result;
}

Estimate relaxation_time_of(const Estimate& diffusion) {
    const double rate = diffusion.mean;
    if (std::isnan(rate)) return diffusion;
    if (!(rate > 0.0)) return {.mean = infinite, .why_no_error = "no error estimate: C(t) does not decay"};
    Estimate time = diffusion;
    time.mean = 1.0 / rate;
    if (diffusion.error) time.error = *diffusion.error / (rate * rate);
    return time;
}

RotationalDiffusion rotational_diffusion(const RotationalCorrelation& correlation, const RotationFit& fit) {
    RotationalDiffusion result;
    const std::vector<double> means = mapped(correlation.values, &Estimate::mean);
    const Lags lags = lags_to_fit(correlation, means, fit);
    result.lags = lags.end - lags.first;
    if (result.lags < 2) {
        result.diffusion = {.mean = nan,
                            .why_no_error =
                                text("{} lags to fit; expected two or more before -ln C(t) passes {}: sample "
                                     "more often, or follow for longer",
                                     result.lags, fit.drop)};
        result.relaxation_time = result.diffusion;
        return result;
    }
    const std::span<const double> times = std::span(correlation.times).subspan(lags.first, result.lags);
    const auto line = [&](std::span<const double> values) {
        const auto fitted = values.subspan(lags.first, result.lags);
        return numerics::fit_line_of_times(times, mapped(fitted, [](double value) { return -std::log(value); }));
    };
    result.diffusion = jackknife(correlation.groups, [&](auto values) { return line(values).slope; });
    result.fast = -std::expm1(-line(means).at_zero);
    result.from = times.front();
    result.to = times.back();
    const double rate = result.diffusion.mean;
    if (correlation.by_time && result.diffusion.error && rate * correlation.segment_time < 3.0) {
        result.diffusion.error.reset();
        result.diffusion.why_no_error = text(
            "no error estimate: segments of {} s are less than three relaxation times of {} s; follow for longer, or "
            "{} rods or more",
            correlation.segment_time, 1.0 / rate, min_groups);
    }
    result.relaxation_time = relaxation_time_of(result.diffusion);
    return result;
}

}  // namespace drover::measure
