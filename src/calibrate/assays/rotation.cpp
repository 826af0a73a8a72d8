// calibrate/assays/rotation.cpp: rotational diffusion of single rods from mean-square angles.
#include <cmath>
#include <numbers>

#include "calibrate/assays/mean_squares.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
/// The mean-square angle at each lag.
Trial follow(const RotationPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
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

std::vector<double> estimates_of(const RotationPlan& plan, std::span<const double> squares) {
    const Line line = line_of(plan, squares, 0, squares.size());  // c + 2 D_r t
    return {0.5 * line.slope, line.at_zero, change_of_slope(plan, squares)};
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    return diffusive_words(estimates[2], "turning", "angle", "D_r");
}
}  // namespace

Assay rotation(const RotationPlan& plan) {
    require_lags(plan, "rotation");
    return {.name = "rotation",
            .population = Population::single_rods,
            .quantities = {{"rotational_diffusion", "1/s", "D_r: <[theta(t) - theta(0)]^2> = c + 2 D_r t"},
                           {"rotational_offset", "1", "c", false},
                           {"rotational_change", "1", "(D_r of longer lags - D_r of shorter lags)/D_r", false}},
            .trial = std::bind_front(follow, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = conclude};
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
