// calibrate/assays/relaxation.cpp: rotational diffusion of single rods in the bed.
#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
constexpr double max_decay = 0.5;    // of -ln C in the fit
constexpr std::size_t min_lags = 4;  // in a fit

/// Lags [first, end) in frames; found: whether the slope is constant there.
struct Regime {
    std::size_t first = 1, end = 1;
    bool found = false;
};

/// -ln C = at_zero + slope t over these lags; means[i] is C after i + 1 frames.
Line line_of(std::span<const double> means, std::size_t first, std::size_t end, double frame) {
    std::vector<double> times, decay;
    for (std::size_t lag = first; lag < end; ++lag) {
        times.push_back(static_cast<double>(lag) * frame);
        decay.push_back(-std::log(means[lag - 1]));
    }
    return numerics::fit_line_of_times(times, decay);
}

/// Whether the slopes from lag `first` on and from twice that on agree, by the jackknife over trials.
bool slopes_agree(std::span<const Trial> trials, const std::vector<double>& means, std::size_t first, std::size_t end,
                  double frame) {
    const auto difference = [&](std::span<const double> of) {
        return line_of(of, 2 * first, end, frame).slope - line_of(of, first, end, frame).slope;
    };
    const double n = static_cast<double>(trials.size());
    std::vector<double> without(means.size());
    double sum = 0.0, squares = 0.0;
    for (const Trial& trial : trials) {
        for (std::size_t i = 0; i < means.size(); ++i) without[i] = (n * means[i] - trial[i]) / (n - 1.0);
        const double change = difference(without);
        sum += change, squares += change * change;
    }
    const double variance = std::max(squares - sum * sum / n, 0.0) * (n - 1.0) / n;
    return std::abs(difference(means)) <= std::sqrt(variance);
}

Regime regime_of(std::span<const Trial> trials, double frame) {
    const std::vector<double> means = means_over(trials);
    Regime regime;
    while (regime.end <= means.size() && means[regime.end - 1] > std::exp(-max_decay)) ++regime.end;
    regime.end =
        std::min(std::max(regime.end, min_lags + 1), means.size() + 1);  // at least min_lags, if C decays at once
    for (; 4 * regime.first + min_lags <= regime.end && !regime.found; regime.first *= 2)
        regime.found = slopes_agree(trials, means, regime.first, regime.end, frame);
    return regime;
}

Trial angle_correlation(const RelaxationPlan& plan, const SystemFactory& make, const dem::Setup& given,
                        std::uint64_t seed) {
    const std::vector<std::vector<RodPose>> frames = rod_frames(plan, make, with_rods(given, false), seed);
    std::vector<std::vector<double>> angles(frames.front().size());
    for (const std::vector<RodPose>& rods : frames)
        for (std::size_t r = 0; r < rods.size(); ++r) angles[r].push_back(rods[r].angle);
    Trial correlation(frames_in(plan.max_lag, plan.frame), 0.0);
    for (const std::vector<double>& of_rod : angles)
        for (std::size_t lag = 1; lag <= correlation.size(); ++lag) {
            double sum = 0.0;
            for (std::size_t i = 0; i + lag < of_rod.size(); ++i) sum += std::cos(of_rod[i + lag] - of_rod[i]);
            correlation[lag - 1] += sum / static_cast<double>((of_rod.size() - lag) * angles.size());
        }
    return correlation;
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    const double from = estimates[2].mean;
    if (std::isnan(from))
        return "no exponential regime: the decay rate still changes at the longest lags; use a longer max_lag and time";
    return text("C(t) = {:.4g} exp(-{:.3g} t) from t = {:.3g} s", 1.0 - estimates[1].mean, estimates[0].mean, from);
}
}  // namespace

Assay relaxation(const RelaxationPlan& plan) {
    require(
        plan.frame > 0.0 && plan.max_lag >= 8.0 * plan.frame && plan.time > plan.max_lag, {},
        "relaxation: frames of {} s, lags up to {} s, a trial of {} s; expected max_lag of at least 8 frames, and a "
        "trial longer than max_lag",
        plan.frame, plan.max_lag, plan.time);
    return {.name = "relaxation",
            .population = Population::single_rods,
            .quantities = {{"relaxation_rate", "1/s", "a = D_r = -d ln C/dt, C(t) = <cos(theta(t) - theta(0))>"},
                           {"rotational_jitter", "1", "1 - c, C(t) = c exp(-a t)", false},
                           {"exponential_from", "s", "t0, the lag from which ln C is a straight line", false}},
            .trial = std::bind_front(angle_correlation, plan),
            .estimator =
                [plan](std::span<const Trial> trials) {
                    const Regime regime = regime_of(trials, plan.frame);
                    const double from = regime.found ? static_cast<double>(regime.first) * plan.frame : nan;
                    return [=](std::span<const double> means) -> std::vector<double> {
                        const Line line = line_of(means, regime.first, regime.end, plan.frame);
                        return {line.slope, -std::expm1(-line.at_zero), from};
                    };
                },
            .conclude = conclude};
}

Rows<RelaxationPlan> RelaxationPlan::rows() {
    using Plan = RelaxationPlan;
    return Rows<RelaxationPlan>{
        {"warm_up", &Plan::warm_up, "before rods are recorded", "s", not_negative},
        {"frame", &Plan::frame, "between samples; a multiple of the plate period, at which rods tilt", "s", positive},
        {"time", &Plan::time, "recorded in each trial", "s", positive},
        {"max_lag", &Plan::max_lag, "longest lag t of C(t), less than time; about 0.5/a if affordable", "s", positive},
    };
}

}  // namespace drover::calibrate
