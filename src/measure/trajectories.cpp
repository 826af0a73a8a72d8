// measure/trajectories.cpp: bodies followed in time: snapshots, speeds along rods, mean-square displacement.
#include "drover/measure/trajectories.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "drover/base/error.hpp"
#include "measure/independent_units.hpp"
#include "measure/spread_over_list.hpp"

namespace drover::measure {

namespace {

double mean_of(std::span<const double> values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Standard deviation of the population; 0 for fewer than two.
double deviation_of(std::span<const double> values) {
    if (values.size() < 2) return 0.0;
    const double mean = mean_of(values);
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

void add_place(Path& path, const dem::Vector& place) {
    path.x.push_back(place.x);
    path.y.push_back(place.y);
}

/// Speeds of one frame of a rod from snapshot i on.
struct FrameSpeed {
    double along_start, along_mean;
};
FrameSpeed frame_speed(const Path& rod, const std::vector<double>& angles, std::size_t i, std::size_t steps,
                       double time) {
    const double vx = (rod.x[i + steps] - rod.x[i]) / time, vy = (rod.y[i + steps] - rod.y[i]) / time;
    double nx = 0.0, ny = 0.0;
    for (std::size_t k = i; k <= i + steps; ++k) {
        const double weight = k == i || k == i + steps ? 0.5 : 1.0;
        nx += weight * std::cos(angles[k]);
        ny += weight * std::sin(angles[k]);
    }
    const double size = std::hypot(nx, ny);
    return {vx * std::cos(angles[i]) + vy * std::sin(angles[i]), size > 0.0 ? (vx * nx + vy * ny) / size : 0.0};
}

/// Paths beside the mean of all of them.
std::vector<Path> about_their_mean(std::span<const Path> bodies) {
    std::vector<Path> result(bodies.begin(), bodies.end());
    for (std::size_t i = 0; i < result[0].x.size(); ++i) {
        double x = 0.0, y = 0.0;
        for (const Path& body : bodies) {
            x += body.x[i] / static_cast<double>(bodies.size());
            y += body.y[i] / static_cast<double>(bodies.size());
        }
        for (Path& body : result) {
            body.x[i] -= x;
            body.y[i] -= y;
        }
    }
    return result;
}

}  // namespace

void add_snapshot(Trajectory& trajectory, double time, const dem::Bodies& bodies) {
    const bool first = trajectory.snapshots == 0;
    if (first) {
        const std::size_t all = bodies.beads.size(), most = std::min(all, max_beads_followed);
        for (std::size_t k = 0; k < most; ++k) trajectory.followed.push_back(spread_over_list(k, most, all));
        std::sort(trajectory.followed.begin(), trajectory.followed.end());
        trajectory.followed.erase(std::unique(trajectory.followed.begin(), trajectory.followed.end()),
                                  trajectory.followed.end());
        trajectory.start = time;
        trajectory.angles.resize(bodies.rods.size());
        trajectory.rods.resize(bodies.rods.size());
        trajectory.beads.resize(trajectory.followed.size());
        trajectory.beads_in_all = all;
    }
    require(bodies.rods.size() == trajectory.rods.size() && bodies.beads.size() == trajectory.beads_in_all, {},
            "{} rods and {} beads at {} s; expected {} and {} as at the start", bodies.rods.size(), bodies.beads.size(),
            time, trajectory.rods.size(), trajectory.beads_in_all);
    if (trajectory.snapshots == 1) {
        require(time > trajectory.start, {}, "a snapshot at {} s after one at {} s; expected a later one", time,
                trajectory.start);
        trajectory.spacing = time - trajectory.start;
    }
    const double due = trajectory.start + static_cast<double>(trajectory.snapshots) * trajectory.spacing;
    require(first || std::abs(time - due) <= 1e-6 * trajectory.spacing * static_cast<double>(trajectory.snapshots), {},
            "a snapshot at {} s; expected one at {} s, {} s apart from the start", time, due, trajectory.spacing);
    for (std::size_t r = 0; r < bodies.rods.size(); ++r) {
        trajectory.angles[r].push_back(std::atan2(bodies.rods[r].axis.y, bodies.rods[r].axis.x));
        add_place(trajectory.rods[r], bodies.rods[r].position);
    }
    for (std::size_t b = 0; b < trajectory.followed.size(); ++b)
        add_place(trajectory.beads[b], bodies.beads[trajectory.followed[b]].position);
    ++trajectory.snapshots;
}

Speeds speeds_along(std::span<const Path> rods, std::span<const std::vector<double>> angles, double spacing,
                    std::size_t steps) {
    require(steps >= 1 && spacing > 0.0, {}, "frames of {} steps of {} s; expected one step or more of a positive time",
            steps, spacing);
    require(rods.size() == angles.size(), {}, "{} paths and angles of {} rods; expected as many", rods.size(),
            angles.size());
    Speeds result{.frame = static_cast<double>(steps) * spacing};
    const std::size_t stretches = stretches_of(rods.size());
    UnitSums units(rods.size() * stretches, 2);
    for (std::size_t r = 0; r < rods.size(); ++r) {
        require(rods[r].x.size() == angles[r].size() && rods[r].y.size() == angles[r].size(), {},
                "rod {}: {} places and {} angles; expected as many", r, rods[r].x.size(), angles[r].size());
        const std::size_t frames = angles[r].empty() ? 0 : (angles[r].size() - 1) / steps;
        std::vector<double> own, own_along_start;
        for (std::size_t frame = 0; frame < frames; ++frame) {
            const FrameSpeed speed = frame_speed(rods[r], angles[r], frame * steps, steps, result.frame);
            const std::size_t unit = r * stretches + stretch_of(frame, frames, stretches);
            units.add(unit, 0, speed.along_start);
            units.add(unit, 1, speed.along_mean);
            own.push_back(speed.along_mean);
            own_along_start.push_back(speed.along_start);
        }
        if (!own.empty()) {
            result.of_rods.push_back(mean_of(own));
            result.of_rods_along_start.push_back(mean_of(own_along_start));
        }
        result.of_frames.insert(result.of_frames.end(), own.begin(), own.end());
    }
    const std::vector<Estimate> means = estimate_each(units.sums, units.counts);
    if (means.size() == 2) {
        result.along_start = means[0];
        result.along_mean = means[1];
    }
    result.spread_of_rods = deviation_of(result.of_rods);
    result.spread_of_frames = deviation_of(result.of_frames);
    return result;
}

Displacement mean_square_displacement(std::span<const Path> bodies, double spacing, std::size_t max_lags,
                                      bool about_mean) {
    require(spacing > 0.0, {}, "places {} s apart; expected a positive time", spacing);
    Displacement result;
    if (bodies.empty()) return result;
    const std::size_t size = bodies[0].x.size(), lags = std::min(max_lags + 1, size);
    for (const Path& body : bodies)
        require(body.x.size() == size && body.y.size() == size, {}, "paths of {} and of {} places; expected one length",
                size, body.x.size());
    std::vector<Path> moved;
    if (about_mean) {
        moved = about_their_mean(bodies);
        bodies = moved;
    }
    const std::size_t stretches = stretches_of(bodies.size());
    UnitSums units(bodies.size() * stretches, lags);
    for (std::size_t b = 0; b < bodies.size(); ++b)
        for (std::size_t i = 0; i < size; ++i) {
            const std::size_t unit = b * stretches + stretch_of(i, size, stretches);
            for (std::size_t lag = 0; lag < lags && i + lag < size; ++lag) {
                const double dx = bodies[b].x[i + lag] - bodies[b].x[i], dy = bodies[b].y[i + lag] - bodies[b].y[i];
                units.add(unit, lag, dx * dx + dy * dy);
            }
        }
    for (std::size_t lag = 0; lag < lags; ++lag) result.times.push_back(static_cast<double>(lag) * spacing);
    result.values = estimate_each(units.sums, units.counts);
    return result;
}

Histogram histogram(std::span<const double> values, std::size_t bins) {
    Histogram result;
    if (values.empty() || bins == 0) return result;
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const double from = *least, range = *most > *least ? *most - *least : 1.0;
    result.width = range / static_cast<double>(bins);
    result.density.assign(bins, 0.0);
    for (const double value : values) {
        const auto bin = std::min(static_cast<std::size_t>((value - from) / result.width), bins - 1);
        result.density[bin] += 1.0 / (static_cast<double>(values.size()) * result.width);
    }
    for (std::size_t bin = 0; bin < bins; ++bin)
        result.middles.push_back(from + (static_cast<double>(bin) + 0.5) * result.width);
    return result;
}

}  // namespace drover::measure
