// measure/trajectories.cpp: speeds along rods.
#include "measure/trajectories.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"

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

}  // namespace drover::measure
