// calibrate/assays/propulsion.cpp: speed of single rods in the bed.
#include <algorithm>
#include <cmath>

#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
/// Means over rods and frames of the speed along n and of n(0).n(frame), and the mean square of the rods' mean speeds.
Trial follow(const PropulsionPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    const std::vector<std::vector<RodPose>> frames = rod_frames(plan, make, with_rods(given, false), seed);
    const double rods = static_cast<double>(frames[0].size()), samples = static_cast<double>(frames.size() - 1);
    std::vector<double> speeds(frames[0].size(), 0.0);
    double turned = 0.0;
    for (std::size_t frame = 1; frame < frames.size(); ++frame) {
        const std::vector<RodPose>&before = frames[frame - 1], &now = frames[frame];
        for (std::size_t r = 0; r < now.size(); ++r) {
            const double along = (now[r].x - before[r].x) * std::cos(before[r].angle) +
                                 (now[r].y - before[r].y) * std::sin(before[r].angle);
            speeds[r] += along / (plan.frame * samples);
            turned += std::cos(now[r].angle - before[r].angle) / (samples * rods);
        }
    }
    Trial trial{0.0, turned, 0.0};
    for (const double speed : speeds) trial[0] += speed / rods, trial[2] += speed * speed / rods;
    return trial;
}

std::vector<double> estimates_of(std::span<const double> means) {
    const double x = -std::log(means[1]);
    const double shortening = x > 0.0 ? -std::expm1(-x) / x : 1.0;
    return {means[0] / shortening, std::sqrt(std::max(means[2] - means[0] * means[0], 0.0))};
}
}  // namespace

Assay propulsion(const PropulsionPlan& plan) {
    require(plan.frame > 0.0 && plan.time >= plan.frame, {},
            "propulsion: a trial of {} s in frames of {} s; expected at least one frame", plan.time, plan.frame);
    return {.name = "propulsion",
            .population = Population::single_rods,
            .quantities = {{"propulsion", "mm/s", "u = <d.n>/frame, corrected for the rotation of n"},
                           {"propulsion_spread", "mm/s", "standard deviation among rods of their mean speeds", false}},
            .trial = std::bind_front(follow, plan),
            .estimator = [](std::span<const Trial>) { return estimates_of; }};
}

Rows<PropulsionPlan> PropulsionPlan::rows() {
    using Plan = PropulsionPlan;
    return Rows<PropulsionPlan>{
        {"warm_up", &Plan::warm_up, "before rods are recorded", "s", not_negative},
        {"time", &Plan::time, "recorded in each trial", "s", positive},
        {"frame", &Plan::frame, "over which displacements are taken", "s", positive},
    };
}

}  // namespace drover::calibrate
