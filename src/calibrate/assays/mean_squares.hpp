// calibrate/assays/mean_squares.hpp: mean squares of displacements at the lags of a plan, and the line through them.
#pragma once
#include "calibrate/assays/plan_support.hpp"

namespace drover::calibrate {

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
inline std::vector<double> squared_displacements(const Path& path, const Lags& lags) {
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
inline std::string diffusive_words(const measure::Estimate& change, const char* motion, const char* of,
                                   const char* coefficient) {
    constexpr double rounding = 1e-12;  // of the fits: no change, however small its error
    constexpr double useful = 0.5;      // a change that is known worse tells nothing
    if (!change.error || *change.error > useful) return text("whether the {} is diffusive is not known", motion);
    if (std::abs(change.mean) <= 2.0 * *change.error + rounding)
        return text("the mean-square {} is linear in time", of);
    return text("not diffusive: {} changes by {:.2g} +- {:.2g} of itself over the lags; use longer lags", coefficient,
                change.mean, *change.error);
}

}  // namespace drover::calibrate
