// measure/trajectories.cpp: the jackknife over groups of unequal size; speeds along rods; autocorrelation of
// directions, and rotational diffusion from it; results from the paths of bodies, frame by frame.
#include "measure/trajectories.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "measure/quasirandom_subset.hpp"
#include "numerics/algebra/extremum.hpp"

namespace drover::measure {

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
Lags lags_to_fit(const std::vector<double>& times, const std::vector<double>& means) {
    Lags lags;
    if (times.size() < 2) return lags;
    while (lags.end < times.size() && means[lags.end] > 0.0 && -std::log(means[lags.end]) <= fitted_drop) ++lags.end;
    const double from = times[lags.end - 1] / range_of_lags - 1e-9 * times[1];
    while (lags.first < lags.end && times[lags.first] < from) ++lags.first;
    return lags;
}

/// Estimates from groups have no autocorrelation time.
SummaryRow row_of(const std::string& name, const std::string& unit, const std::string& formula, Estimate estimate) {
    estimate.autocorrelation_time = nan;
    return {.name = name, .unit = unit, .formula = formula, .estimates = {std::move(estimate)}};
}

/// Fits the correlation, computed to the end of the fit: that comes soon where rods lose their direction, and costs
/// rods x frames x lags where they do not.
RotationalDiffusion diffusion_of(const Paths& paths) {
    constexpr double max_products = 1e9;
    constexpr std::size_t first_lags = 16, min_lags = 2;
    const double each = static_cast<double>(paths.rods.size()) * static_cast<double>(paths.added);
    const auto affordable = static_cast<std::size_t>(max_products / each);
    const std::size_t max_lags = std::max(min_lags, std::min((paths.added - 1) / 2, affordable));
    std::size_t lags = std::min(first_lags, max_lags);
    for (;; lags = std::min(2 * lags, max_lags)) {
        const RotationalCorrelation correlation = rotational_correlation(paths.angles, paths.spacing, lags);
        const double last = correlation.values.back().mean;
        if (lags == max_lags || !(last > std::exp(-fitted_drop))) return rotational_diffusion(correlation);
    }
}

/// Standard deviation of the means of rods.  Its error is that by the jackknife, but at least that by moments, with var
/// s^2 = (m_4 - s^4 (n - 3)/(n - 1))/n: where rods have two speeds, the jackknife finds all spreads without one equal.
Estimate deviation_of(std::span<const double> of_rods) {
    const double count = static_cast<double>(of_rods.size());
    double mean = 0.0, square = 0.0, fourth = 0.0;
    for (const double speed : of_rods) mean += speed / count;
    GroupSums groups(of_rods.size(), 2);
    // Relative to the mean: the squares of a large common speed would lose the spread to rounding.
    for (std::size_t r = 0; r < of_rods.size(); ++r) {
        const double away = of_rods[r] - mean;
        groups.add(r, 0, away);
        groups.add(r, 1, away * away);
        square += away * away / (count - 1.0);
        fourth += away * away * away * away / count;
    }
    Estimate result =
        jackknife(groups, [](auto means) { return std::sqrt(std::max(0.0, means[1] - means[0] * means[0])); });
    result.mean = std::sqrt(square);
    if (of_rods.size() < 3) {
        result.error.reset();
        result.why_no_error = "no error estimate: two rods; expected three or more";
    } else if (result.error && square > 0.0) {
        const double variance = (fourth - square * square * (count - 3.0) / (count - 1.0)) / count;
        result.error = std::max(*result.error * std::sqrt(count / (count - 1.0)),
                                0.5 * std::sqrt(std::max(0.0, variance) / square));
    }
    return result;
}

/// The mean of each quantity, sum over number whatever the sizes of the groups, with its error by the jackknife.
std::vector<Estimate> jackknife_means(const GroupSums& group_sums) {
    const auto& [sums, counts] = group_sums;
    std::vector<Estimate> result;
    const std::size_t quantities = sums.empty() ? 0 : sums[0].size();
    for (std::size_t k = 0; k < quantities; ++k) {
        GroupSums one(sums.size(), 1);
        double sum = 0.0, count = 0.0;
        for (std::size_t g = 0; g < sums.size(); ++g) {
            one.sums[g][0] = sums[g][k];
            one.counts[g][0] = counts[g][k];
            sum += sums[g][k];
            count += counts[g][k];
        }
        result.push_back(jackknife(one, [](auto means) { return means[0]; }));
        result.back().mean = sum / count;  // a plain mean has no bias: the correction for unequal groups is noise
    }
    return result;
}

Estimate head_first_fraction(std::span<const double> of_rods) {
    GroupSums groups(of_rods.size(), 1);
    std::size_t head_first = 0;
    for (std::size_t r = 0; r < of_rods.size(); ++r) {
        groups.add(r, 0, of_rods[r] > 0.0 ? 1.0 : 0.0);
        if (of_rods[r] > 0.0) ++head_first;
    }
    Estimate fraction = jackknife_means(groups).front();
    if (fraction.error && (head_first == 0 || head_first == of_rods.size())) {
        fraction.error.reset();
        fraction.why_no_error =
            text("no error estimate: all {} rods move the same way, so the binomial error is not known",
                 of_rods.size());
    }
    return fraction;
}

void add_rod_rows(const Paths& paths, std::vector<SummaryRow>& rows) {
    const Speeds speeds = speeds_along(paths.rods, paths.angles, paths.spacing);
    const std::string of_frame =
        text("d.n/T, d the displacement over the frame time T = {} s, n at its start", paths.spacing);
    rows.push_back(row_of("rod_speed", "mm s-1", "mean over rods and frames of " + of_frame, speeds.mean));
    if (paths.rods.size() > 1)
        rows.push_back(row_of("rod_speed_deviation", "mm s-1",
                              "standard deviation among rods of the mean over frames of " + of_frame,
                              deviation_of(speeds.of_rods)));
    rows.push_back(row_of("rod_head_first_fraction", "1",
                          "fraction of rods that move head-first: with a positive mean over frames of " + of_frame,
                          head_first_fraction(speeds.of_rods)));
    const RotationalDiffusion diffusion = diffusion_of(paths);
    rows.push_back(row_of("rotational_diffusion", "rad2 s-1",
                          "D_r of C(t) = <cos(theta(t0 + t) - theta(t0))> = c exp(-D_r t), over rods and times t0",
                          diffusion.diffusion));
    rows.push_back(row_of("relaxation_time", "s", "1/D_r", diffusion.relaxation_time));
}

/// Throws unless the frame is expected and has the bodies of the paths.
void check_frame(const Paths& paths, std::span<const double> rod_position, std::span<const double> rod_axis,
                 std::span<const double> bead_position) {
    require(paths.added < paths.frames, {}, "a frame after {}; expected no further one", paths.added);
    const std::size_t rods = paths.rods.size();
    require(rod_position.size() == 3 * rods && rod_axis.size() == 3 * rods, {},
            "{} and {} coordinates of rods; expected 3 for each of {}", rod_position.size(), rod_axis.size(), rods);
    require(paths.followed.empty() || 3 * paths.followed.back() + 2 < bead_position.size(), {},
            "{} coordinates of beads; expected 3 for each", bead_position.size());
}

/// The mean of one quantity over bodies, groups, and over time, the samples: bodies keep their differences, such as
/// their gaits, and what they do together does not average out over them.  The error is the larger of both; that over
/// bodies alone where the samples are too short for one.
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

/// Beads flow together, so that their number says little of the error.
Estimate bead_displacement_of(const Paths& paths) {
    const Samples samples{.series = {paths.of_frames}, .spacing = paths.spacing};
    const Estimate over_time = estimate_mean(samples, 0);
    return over_time.error ? with_error_over_time(paths.of_beads, samples) : over_time;
}
}  // namespace

Estimate jackknife(const GroupSums& group_sums, const std::function<double(std::span<const double> means)>& function) {
    const auto& [sums, counts] = group_sums;
    const std::size_t quantities = sums.empty() ? 0 : sums[0].size();
    std::vector<double> total(quantities), number(quantities), means(quantities), left_out;
    std::vector<std::size_t> filled;
    for (std::size_t g = 0; g < sums.size(); ++g) {
        double values = 0.0;
        for (std::size_t k = 0; k < quantities; ++k) {
            total[k] += sums[g][k];
            number[k] += counts[g][k];
            values += counts[g][k];
        }
        if (values > 0.0) filled.push_back(g);
    }
    for (std::size_t k = 0; k < quantities; ++k) means[k] = total[k] / number[k];
    Estimate result{.mean = quantities > 0 ? function(means) : nan};
    for (const double count : number) result.samples = std::max(result.samples, static_cast<std::size_t>(count));
    if (!std::isfinite(result.mean)) {
        result.why_no_error = "no error estimate: there is no finite value";
        return result;
    }
    if (filled.size() < 2) {
        result.why_no_error =
            "no error estimate: there is only one independent value; follow more bodies, or for longer";
        return result;
    }
    double sum = 0.0, squares = 0.0;
    for (const std::size_t g : filled) {
        for (std::size_t k = 0; k < quantities; ++k) means[k] = (total[k] - sums[g][k]) / (number[k] - counts[g][k]);
        left_out.push_back(function(means));
        sum += left_out.back();
    }
    const auto groups = static_cast<double>(filled.size());
    for (const double value : left_out) squares += (value - sum / groups) * (value - sum / groups);
    const double error = std::sqrt((groups - 1.0) / groups * squares);
    if (!std::isfinite(error)) {
        result.why_no_error = "no error estimate: all values of one quantity are in one group";
        return result;
    }
    result.mean -= (groups - 1.0) * (sum / groups - result.mean);
    result.error = error;
    result.blocks = filled.size();
    return result;
}

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
    // Into how many segments of time the path of each body is cut: see min_groups.
    const std::size_t bodies = angles.size(), lags = std::min(max_lags + 1, longest),
                      segments = bodies == 0 || bodies >= min_groups ? 1 : (min_groups + bodies - 1) / bodies;
    RotationalCorrelation result{.groups = GroupSums(angles.size() * segments, lags), .by_time = segments > 1};
    for (std::size_t rod = 0; rod < angles.size(); ++rod) {
        const std::size_t size = angles[rod].size();
        std::vector<double> x(size), y(size);
        for (std::size_t i = 0; i < size; ++i) {
            x[i] = std::cos(angles[rod][i]);
            y[i] = std::sin(angles[rod][i]);
        }
        for (std::size_t i = 0; i < size; ++i) {
            const std::size_t group = rod * segments + i * segments / size;
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

RotationalDiffusion rotational_diffusion(const RotationalCorrelation& correlation) {
    RotationalDiffusion result;
    const std::vector<double> means = mapped(correlation.values, &Estimate::mean);
    const Lags lags = lags_to_fit(correlation.times, means);
    const std::size_t count = lags.end - lags.first;
    if (count < 2) {
        result.diffusion = {.mean = nan,
                            .why_no_error =
                                text("{} lags to fit; expected two or more before -ln C(t) passes {}: sample "
                                     "more often, or follow for longer",
                                     count, fitted_drop)};
        result.relaxation_time = result.diffusion;
        return result;
    }
    const std::span<const double> times = std::span(correlation.times).subspan(lags.first, count);
    const auto line = [&](std::span<const double> values) {
        const auto fitted = values.subspan(lags.first, count);
        return numerics::fit_line_of_times(times, mapped(fitted, [](double value) { return -std::log(value); }));
    };
    result.diffusion = jackknife(correlation.groups, [&](auto values) { return line(values).slope; });
    result.fast = -std::expm1(-line(means).at_zero);
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

Paths make_paths(double spacing, std::size_t frames, std::size_t rods, std::size_t beads) {
    require(spacing > 0.0 && std::isfinite(spacing), {}, "frames {} s apart; expected a positive time", spacing);
    Paths paths{.spacing = spacing, .frames = frames};
    paths.angles.resize(rods);
    paths.rods.resize(rods);
    for (std::size_t r = 0; r < rods; ++r) {
        paths.angles[r].reserve(frames);
        paths.rods[r].x.reserve(frames);
        paths.rods[r].y.reserve(frames);
    }
    const std::size_t chosen = std::min(beads, max_beads_followed);
    for (std::size_t k = 0; k < chosen; ++k) paths.followed.push_back(quasirandom_index(k, chosen, beads));
    std::ranges::sort(paths.followed);
    paths.followed.erase(std::unique(paths.followed.begin(), paths.followed.end()), paths.followed.end());
    paths.of_beads = GroupSums(paths.followed.size(), 1);
    return paths;
}

void add_frame(Paths& paths, std::span<const double> rod_position, std::span<const double> rod_axis,
               std::span<const double> bead_position) {
    check_frame(paths, rod_position, rod_axis, bead_position);
    for (std::size_t r = 0; r < paths.rods.size(); ++r) {
        paths.angles[r].push_back(std::atan2(rod_axis[3 * r + 1], rod_axis[3 * r]));
        paths.rods[r].x.push_back(rod_position[3 * r]);
        paths.rods[r].y.push_back(rod_position[3 * r + 1]);
    }
    std::vector<double> now;
    for (const std::size_t bead : paths.followed)
        now.insert(now.end(), {bead_position[3 * bead], bead_position[3 * bead + 1]});
    double sum = 0.0;
    for (std::size_t b = 0; b < paths.followed.size() && paths.added > 0; ++b) {
        const double dx = now[2 * b] - paths.previous[2 * b], dy = now[2 * b + 1] - paths.previous[2 * b + 1];
        paths.of_beads.add(b, 0, dx * dx + dy * dy);
        sum += dx * dx + dy * dy;
    }
    if (paths.added > 0) paths.of_frames.push_back(sum / static_cast<double>(paths.followed.size()));
    paths.previous = std::move(now);
    ++paths.added;
}

std::vector<SummaryRow> path_rows(const Paths& paths) {
    std::vector<SummaryRow> rows;
    const bool enough = paths.added >= 2;
    const Estimate none{.mean = nan,
                        .why_no_error =
                            text("{} frame{} after the warm-up, one every {} s; expected two or more: run for longer, "
                                 "or reduce output.frame_every",
                                 paths.added, paths.added == 1 ? "" : "s", paths.spacing)};
    if (!paths.rods.empty() && enough) add_rod_rows(paths, rows);
    if (!paths.rods.empty() && !enough)
        for (const auto& [name, unit] : {std::pair{"rod_speed", "mm s-1"},
                                         {"rod_head_first_fraction", "1"},
                                         {"rotational_diffusion", "rad2 s-1"},
                                         {"relaxation_time", "s"}})
            rows.push_back(row_of(name, unit, "too few frames after the warm-up", none));
    if (!paths.followed.empty())
        rows.push_back(row_of("bead_displacement_squared", "mm2",
                              text("<|r(t + T) - r(t)|^2> in the plane over {} beads and times t, T = {} s",
                                   paths.followed.size(), paths.spacing),
                              enough ? bead_displacement_of(paths) : none));
    return rows;
}

double persistence(const Paths& paths) {
    double sum = 0.0;
    std::size_t turns = 0;
    for (const std::vector<double>& angles : paths.angles)
        for (std::size_t i = 1; i < angles.size(); ++i, ++turns) sum += std::cos(angles[i] - angles[i - 1]);
    return sum / static_cast<double>(turns);
}

}  // namespace drover::measure
