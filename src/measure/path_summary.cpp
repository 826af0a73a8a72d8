// measure/path_summary.cpp: paths of bodies, frame by frame, to rows of results.
#include "drover/measure/path_summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/base/error.hpp"
#include "measure/independent_units.hpp"
#include "measure/spread_over_list.hpp"

namespace drover::measure {

namespace {
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Estimates from units have no autocorrelation time.
SummaryRow row_of(const std::string& name, const std::string& unit, const std::string& formula, Estimate estimate) {
    estimate.autocorrelation_time = not_a_number;
    return {.name = name, .unit = unit, .formula = formula, .axes = {}, .estimates = {std::move(estimate)}};
}

/// The correlation up to where the fit ends: it falls soon where rods lose their direction, and costs rods x frames x lags where they do not.
RotationalDiffusion diffusion_of(const Paths& paths) {
    constexpr double max_products = 1e9;
    constexpr std::size_t lags_first = 16, lags_fewest = 2;
    const RotationFit fit;
    const double each = static_cast<double>(paths.rods.size()) * static_cast<double>(paths.added);
    const auto affordable = static_cast<std::size_t>(max_products / each);
    const std::size_t most = std::max(lags_fewest, std::min((paths.added - 1) / 2, affordable));
    std::size_t lags = std::min(lags_first, most);
    for (;; lags = std::min(2 * lags, most)) {
        const RotationalCorrelation correlation = rotational_correlation(paths.angles, paths.spacing, lags);
        const double last = correlation.values.back().mean;
        if (lags == most || !(last > std::exp(-fit.drop))) return rotational_diffusion(correlation, fit);
    }
}

/// Standard deviation of the means of rods, as Speeds::spread_of_rods, with its error by the jackknife over rods.
Estimate deviation_of(std::span<const double> of_rods) {
    const double count = static_cast<double>(of_rods.size());
    double mean = 0.0;
    for (const double speed : of_rods) mean += speed / count;
    UnitSums units(of_rods.size(), 2);
    for (std::size_t r = 0; r < of_rods.size();
         ++r) {  // beside the mean: squares of what is common would round it away
        units.add(r, 0, of_rods[r] - mean);
        units.add(r, 1, (of_rods[r] - mean) * (of_rods[r] - mean));
    }
    return estimate_units(units.sums, units.counts,
                          [](auto means) { return std::sqrt(std::max(0.0, means[1] - means[0] * means[0])); });
}

Estimate ahead_share(std::span<const double> of_rods) {
    UnitSums units(of_rods.size(), 1);
    std::size_t ahead = 0;
    for (std::size_t r = 0; r < of_rods.size(); ++r) {
        units.add(r, 0, of_rods[r] > 0.0 ? 1.0 : 0.0);
        if (of_rods[r] > 0.0) ++ahead;
    }
    Estimate share = estimate_each(units.sums, units.counts).front();
    if (share.error && (ahead == 0 || ahead == of_rods.size())) {
        share.error.reset();
        share.refusal = text("error refused: all {} rods go the same way, and how many of more would not is not told",
                             of_rods.size());
    }
    return share;
}

void add_rod_rows(const Paths& paths, std::vector<SummaryRow>& rows) {
    const Speeds speeds = speeds_along(paths.rods, paths.angles, paths.spacing, 1);
    const std::string of_frame =
        text("d.n/T, d the displacement over the frame time T = {} s, n at its start", paths.spacing);
    rows.push_back(row_of("rod_speed", "mm s-1", "mean over rods and frames of " + of_frame, speeds.along_start));
    if (paths.rods.size() > 1)
        rows.push_back(row_of("rod_speed_deviation", "mm s-1",
                              "standard deviation among rods of the mean of each of " + of_frame,
                              deviation_of(speeds.of_rods_along_start)));
    rows.push_back(row_of("rod_speed_ahead_share", "1", "share of rods that go ahead: whose mean is > 0 of " + of_frame,
                          ahead_share(speeds.of_rods_along_start)));
    const RotationalDiffusion diffusion = diffusion_of(paths);
    rows.push_back(row_of("rotational_diffusion", "rad2 s-1",
                          "D_r of C(t) = <cos(theta(t0 + t) - theta(t0))> = c exp(-D_r t), over rods and times t0",
                          diffusion.diffusion));
    rows.push_back(row_of("relaxation_time", "s", "1/D_r", diffusion.relaxation_time));
}

/// A frame that came has the bodies that were to come.
void check_frame(const Paths& paths, std::span<const double> rod_position, std::span<const double> rod_axis,
                 std::span<const double> bead_position) {
    require(paths.added < paths.frames, {}, "a frame after {}; expected no more", paths.added);
    const std::size_t rods = paths.rods.size();
    require(rod_position.size() == 3 * rods && rod_axis.size() == 3 * rods, {},
            "{} and {} numbers of rods; expected 3 for each of {}", rod_position.size(), rod_axis.size(), rods);
    require(paths.followed.empty() || 3 * paths.followed.back() + 2 < bead_position.size(), {},
            "{} numbers of beads; expected 3 for each", bead_position.size());
}

}  // namespace

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
    const std::size_t most = std::min(beads, max_beads_followed);
    for (std::size_t k = 0; k < most; ++k) paths.followed.push_back(spread_over_list(k, most, beads));
    std::sort(paths.followed.begin(), paths.followed.end());
    paths.followed.erase(std::unique(paths.followed.begin(), paths.followed.end()), paths.followed.end());
    const UnitSums units(paths.followed.size() * stretches_of(paths.followed.size()), 1);
    paths.sums = units.sums;
    paths.counts = units.counts;
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
    const std::size_t stretches = stretches_of(paths.followed.size());
    std::vector<double> now;
    for (const std::size_t bead : paths.followed)
        now.insert(now.end(), {bead_position[3 * bead], bead_position[3 * bead + 1]});
    for (std::size_t b = 0; b < paths.followed.size() && paths.added > 0; ++b) {
        const double dx = now[2 * b] - paths.before[2 * b], dy = now[2 * b + 1] - paths.before[2 * b + 1];
        const std::size_t unit = b * stretches + stretch_of(paths.added - 1, paths.frames - 1, stretches);
        paths.sums[unit][0] += dx * dx + dy * dy;
        paths.counts[unit][0] += 1.0;
    }
    paths.before = std::move(now);
    ++paths.added;
}

std::vector<SummaryRow> path_rows(const Paths& paths) {
    std::vector<SummaryRow> rows;
    const bool enough = paths.added >= 2;
    const Estimate none{.mean = not_a_number,
                        .refusal = text("{} frames of {} s after the warm-up; expected two or more: run for longer, or "
                                        "make output.frame_every shorter",
                                        paths.added, paths.spacing)};
    if (!paths.rods.empty() && enough) add_rod_rows(paths, rows);
    if (!paths.rods.empty() && !enough)
        for (const auto& [name, unit] : {std::pair{"rod_speed", "mm s-1"},
                                         {"rod_speed_ahead_share", "1"},
                                         {"rotational_diffusion", "rad2 s-1"},
                                         {"relaxation_time", "s"}})
            rows.push_back(row_of(name, unit, "from the frames after the warm-up, of which there are too few", none));
    if (!paths.followed.empty())
        rows.push_back(row_of("bead_displacement_squared", "mm2",
                              text("<|r(t + T) - r(t)|^2> in the plane over {} beads and times t, T = {} s",
                                   paths.followed.size(), paths.spacing),
                              enough ? estimate_each(paths.sums, paths.counts).front() : none));
    return rows;
}

}  // namespace drover::measure
