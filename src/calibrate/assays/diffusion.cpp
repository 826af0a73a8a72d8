// calibrate/assays/diffusion.cpp: self-diffusion of beads and of single rods from mean-square displacements, and
// rotational diffusion of single rods from mean-square angles.
#include <cmath>
#include <numbers>

#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
/// Lags of a fit in frames: [first, end).
struct Lags {
    std::size_t first = 1, end = 1;
    std::size_t count() const { return end - first; }
};
template <class Plan>
Lags lags_of(const Plan& plan) {
    return {.first = frames_in(plan.min_lag, plan.frame), .end = frames_in(plan.max_lag, plan.frame) + 1};
}

/// Throws an input Error unless a trial has the lags of the plan, and at least four of them: two in each half.
template <class Plan>
void require_lags(const Plan& plan, const char* assay) {
    constexpr std::size_t min_lags = 4;
    require(
        plan.frame > 0.0 && plan.min_lag >= plan.frame && plan.time >= plan.max_lag + plan.frame, {},
        "{}: frames of {} s, lags of {} to {} s, a trial of {} s; expected a shortest lag of at least one frame, and "
        "a trial at least one frame longer than the longest lag",
        assay, plan.frame, plan.min_lag, plan.max_lag, plan.time);
    require(plan.max_lag >= plan.min_lag + static_cast<double>(min_lags - 1) * plan.frame * (1.0 - 1e-9), {},
            "{}: lags of {} to {} s in frames of {} s; expected at least {} lags: raise max_lag or lower frame", assay,
            plan.min_lag, plan.max_lag, plan.frame, min_lags);
}

/// One coordinate of one particle, by frame.
using Path = std::vector<double>;

/// Mean over start times of the squared displacement at each lag.
std::vector<double> squared_displacements(const Path& path, const Lags& lags) {
    std::vector<double> squares;
    for (std::size_t lag = lags.first; lag < lags.end; ++lag) {
        double sum = 0.0;
        for (std::size_t i = 0; i + lag < path.size(); ++i)
            sum += (path[i + lag] - path[i]) * (path[i + lag] - path[i]);
        squares.push_back(sum / static_cast<double>(path.size() - lag));
    }
    return squares;
}

/// The line through the mean squares at the lags numbered [begin, end) of the fit, with weights 1/t^2.
template <class Plan>
Line line_of(const Plan& plan, std::span<const double> squares, std::size_t begin, std::size_t end) {
    std::vector<double> times;
    for (std::size_t i = begin; i < end; ++i)
        times.push_back(static_cast<double>(lags_of(plan).first + i) * plan.frame);
    return numerics::fit_line_of_times(times, squares.subspan(begin, end - begin));
}

/// (slope of the longer half of the lags - slope of the shorter half)/slope, 0 for diffusive motion.
template <class Plan>
double change_of_slope(const Plan& plan, std::span<const double> squares) {
    const std::size_t count = squares.size(), half = count / 2;
    return (line_of(plan, squares, half, count).slope - line_of(plan, squares, 0, half).slope) /
           line_of(plan, squares, 0, count).slope;
}

/// Whether the mean square of an angle or a displacement grows as diffusion makes it, from its change_of_slope().
std::string diffusive_words(const measure::Estimate& change, const char* motion, const char* of,
                            const char* coefficient) {
    constexpr double rounding = 1e-12;  // of the fits: no change, however small its error
    constexpr double useful = 0.5;      // a change that is known worse tells nothing
    if (!change.error || *change.error > useful) return text("whether the {} is diffusive is not known", motion);
    if (std::abs(change.mean) <= 2.0 * *change.error + rounding)
        return text("the mean-square {} is linear in time", of);
    return text("not diffusive: {} changes by {:.2g} +- {:.2g} of itself over the lags; use longer lags", coefficient,
                change.mean, *change.error);
}

std::vector<double> bead_displacements(const DiffusionPlan& plan, const SystemFactory& make, const dem::Setup& given,
                                       std::uint64_t seed) {
    const auto system = make(beads_alone(given), seed);
    const Lags lags = lags_of(plan);
    const std::size_t frames = frames_in(plan.time, plan.frame);
    std::vector<Path> x, y;
    for (std::size_t frame = 0; frame <= frames; ++frame) {
        system->advance_to(plan.warm_up + static_cast<double>(frame) * plan.frame);
        const std::vector<Position> beads = system->bead_positions();
        require(beads.size() >= 2, {}, "diffusion: {} beads; expected two or more, since drift of the bed is removed",
                beads.size());
        Position mean;
        for (const Position& bead : beads) {
            mean.x += bead.x / static_cast<double>(beads.size());
            mean.y += bead.y / static_cast<double>(beads.size());
        }
        x.resize(beads.size()), y.resize(beads.size());
        for (std::size_t b = 0; b < beads.size(); ++b) {
            x[b].push_back(beads[b].x - mean.x);
            y[b].push_back(beads[b].y - mean.y);
        }
    }
    std::vector<double> squares(lags.count(), 0.0);
    for (std::size_t b = 0; b < x.size(); ++b) {
        const std::vector<double> along_x = squared_displacements(x[b], lags),
                                  along_y = squared_displacements(y[b], lags);
        for (std::size_t i = 0; i < squares.size(); ++i)
            squares[i] += (along_x[i] + along_y[i]) / static_cast<double>(x.size() - 1);
    }
    return squares;
}

/// The paths of one rod along and across its axis.
struct BodyPath {
    Path along{0.0}, across{0.0};
    void add(const RodPose& before, const RodPose& now) {
        const double angle = before.angle + 0.5 * std::remainder(now.angle - before.angle, 2.0 * std::numbers::pi);
        const double dx = now.x - before.x, dy = now.y - before.y;
        along.push_back(along.back() + dx * std::cos(angle) + dy * std::sin(angle));
        across.push_back(across.back() - dx * std::sin(angle) + dy * std::cos(angle));
    }
};

std::vector<double> rod_displacements(const DiffusionPlan& plan, const SystemFactory& make, const dem::Setup& given,
                                      std::uint64_t seed) {
    const std::vector<std::vector<RodPose>> rods = rod_frames(plan, make, with_rods(given, false), seed);
    const Lags lags = lags_of(plan);
    const std::size_t frames = rods.size() - 1;
    std::vector<BodyPath> paths(rods.front().size());
    for (std::size_t frame = 1; frame <= frames; ++frame)
        for (std::size_t r = 0; r < paths.size(); ++r) paths[r].add(rods[frame - 1][r], rods[frame][r]);
    std::vector<double> squares(lags.count(), 0.0);
    for (BodyPath& path : paths) {
        const double step = path.along.back() / static_cast<double>(frames);  // u of this rod times the frame
        for (std::size_t i = 0; i < path.along.size(); ++i) path.along[i] -= step * static_cast<double>(i);
        const std::vector<double> along = squared_displacements(path.along, lags),
                                  across = squared_displacements(path.across, lags);
        for (std::size_t i = 0; i < squares.size(); ++i) {
            const double left = 1.0 - static_cast<double>(lags.first + i) / static_cast<double>(frames);
            squares[i] += (along[i] / left + across[i]) / static_cast<double>(paths.size());
        }
    }
    return squares;
}

/// The mean-square displacements of beads, then those of rods, at all lags of the fit.
Trial follow(const DiffusionPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    require_beads(given, "diffusion");
    Trial trial = bead_displacements(plan, make, given, seed);
    const std::vector<double> rods = rod_displacements(plan, make, given, trial_seed(seed, "rods", 0));
    trial.insert(trial.end(), rods.begin(), rods.end());
    return trial;
}

std::vector<double> estimates_of(const DiffusionPlan& plan, std::span<const double> means) {
    const std::size_t count = means.size() / 2;
    std::vector<double> values;
    for (const std::span<const double> squares : {means.first(count), means.last(count)}) {
        const Line line = line_of(plan, squares, 0, count);
        values.insert(values.end(), {0.25 * line.slope, line.at_zero, change_of_slope(plan, squares)});
    }
    return {values[0], values[3], values[1], values[4], values[2], values[5]};
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    std::string diagnosis;
    for (const auto& [name, q] : {std::pair{"beads", 4u}, std::pair{"rods", 5u}}) {
        diagnosis += diagnosis.empty() ? "" : "; ";
        diagnosis += text("{}: {}", name, diffusive_words(estimates[q], "motion", "displacement", "D"));
    }
    return diagnosis;
}
/// The mean-square angle at each lag.
Trial follow_turns(const RotationPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    const std::vector<std::vector<RodPose>> frames = rod_frames(plan, make, with_rods(given, false), seed);
    const std::size_t rods = frames.front().size();
    std::vector<Path> angles(rods, {0.0});
    for (std::size_t frame = 1; frame < frames.size(); ++frame)
        for (std::size_t r = 0; r < rods; ++r)
            angles[r].push_back(angles[r].back() + std::remainder(frames[frame][r].angle - frames[frame - 1][r].angle,
                                                                  2.0 * std::numbers::pi));
    const Lags lags = lags_of(plan);
    Trial squares(lags.count(), 0.0);
    for (const Path& path : angles) {
        const std::vector<double> one = squared_displacements(path, lags);
        for (std::size_t i = 0; i < squares.size(); ++i) squares[i] += one[i] / static_cast<double>(rods);
    }
    return squares;
}

std::vector<double> estimates_of_turns(const RotationPlan& plan, std::span<const double> squares) {
    const Line line = line_of(plan, squares, 0, squares.size());  // c + 2 D_r t
    return {0.5 * line.slope, line.at_zero, change_of_slope(plan, squares)};
}
}  // namespace

Assay diffusion(const DiffusionPlan& plan) {
    require_lags(plan, "diffusion");
    return {.name = "diffusion",
            .population = Population::single_rods,
            .quantities = {{"bead_diffusion", "mm^2/s", "D of beads: <|r(t) - r(0)|^2> = c + 4 D t, without rods"},
                           {"rod_diffusion", "mm^2/s", "D of single rods, without propulsion"},
                           {"bead_diffusion_offset", "mm^2", "c of beads", false},
                           {"rod_diffusion_offset", "mm^2", "c of rods", false},
                           {"bead_diffusion_change", "1", "(D of longer lags - D of shorter lags)/D, beads", false},
                           {"rod_diffusion_change", "1", "(D of longer lags - D of shorter lags)/D, rods", false}},
            .trial = std::bind_front(follow, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = conclude};
}

Rows<DiffusionPlan> DiffusionPlan::rows() {
    using Plan = DiffusionPlan;
    return Rows<DiffusionPlan>{
        {"warm_up", &Plan::warm_up, "before positions are recorded", "s", not_negative},
        {"frame", &Plan::frame, "between recorded positions; a multiple of the plate period", "s", positive},
        {"time", &Plan::time, "recorded in each trial", "s", positive},
        {"min_lag", &Plan::min_lag, "shortest lag of the fit; longer than ballistic motion and rattling in a cage", "s",
         positive},
        {"max_lag", &Plan::max_lag, "longest lag of the fit; less than time", "s", positive},
    };
}

Assay rotation(const RotationPlan& plan) {
    require_lags(plan, "rotation");
    return {.name = "rotation",
            .population = Population::single_rods,
            .quantities = {{"rotational_diffusion", "1/s", "D_r: <[theta(t) - theta(0)]^2> = c + 2 D_r t"},
                           {"rotational_offset", "1", "c", false},
                           {"rotational_change", "1", "(D_r of longer lags - D_r of shorter lags)/D_r", false}},
            .trial = std::bind_front(follow_turns, plan),
            .estimator = always(std::bind_front(estimates_of_turns, plan)),
            .conclude = [](std::vector<measure::Estimate>& estimates) {
                return diffusive_words(estimates[2], "turning", "angle", "D_r");
            }};
}

Rows<RotationPlan> RotationPlan::rows() {
    using Plan = RotationPlan;
    return Rows<RotationPlan>{
        {"warm_up", &Plan::warm_up, "before angles are recorded", "s", not_negative},
        {"frame", &Plan::frame, "between recorded angles; a rod turns by less than half a turn in it", "s", positive},
        {"time", &Plan::time, "recorded in each trial", "s", positive},
        {"min_lag", &Plan::min_lag, "shortest lag of the fit; longer than a rod keeps its rate of turning", "s",
         positive},
        {"max_lag", &Plan::max_lag, "longest lag of the fit; less than time", "s", positive},
    };
}

}  // namespace drover::calibrate
