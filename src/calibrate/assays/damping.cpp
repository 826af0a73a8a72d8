// calibrate/assays/damping.cpp: damping of bead flow by the plates.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/constants.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
/// v and x along the imposed flow after 0, 1, ... frames, averaged over releases: v0, x0, v1, x1, ...
Trial release(const DampingPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    dem::Setup setup = beads_alone(given);
    setup.forces = {.hold_beads = true};
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    const std::size_t frames = frames_in(plan.time, plan.frame);
    Trial trial(2 * (frames + 1), 0.0);
    for (int i = 0; i < plan.releases; ++i) {
        const double x = i % 2 == 0 ? (i % 4 == 0 ? 1.0 : -1.0) : 0.0, y = i % 2 == 1 ? (i % 4 == 1 ? 1.0 : -1.0) : 0.0;
        system->impose({.hold_beads = true, .bead_velocity_x = x * plan.speed, .bead_velocity_y = y * plan.speed});
        system->advance_to(time += plan.hold);
        system->impose({});
        const BeadMotion start = system->beads();
        for (std::size_t frame = 0; frame <= frames; ++frame) {
            system->advance_to(time + static_cast<double>(frame) * plan.frame);
            const BeadMotion now = system->beads();
            trial[2 * frame] += (x * now.vx + y * now.vy) / plan.releases;
            trial[2 * frame + 1] += (x * (now.x - start.x) + y * (now.y - start.y)) / plan.releases;
        }
        time += static_cast<double>(frames) * plan.frame;
    }
    return trial;
}

/// First frame with a lower speed than this, or the last frame.
std::size_t frame_below(std::span<const double> means, double speed) {
    std::size_t frame = 0;
    while (2 * (frame + 1) < means.size() && means[2 * frame] >= speed) ++frame;
    return frame;
}

/// Frames at which the fit and its thirds end, and whether the beads slowed down to the flock speed.
struct FitRange {
    std::array<std::size_t, 4> ends{};
    bool reaches_flock = false;
};
FitRange fit_range(const DampingPlan& plan, std::span<const Trial> trials) {
    const std::vector<double> means = means_over(trials);
    FitRange range;
    auto& ends = range.ends;
    for (std::size_t third = 1; third <= 3; ++third) {
        const double speed = plan.speed * std::pow(plan.min_speed / plan.speed, static_cast<double>(third) / 3.0);
        ends[third] = std::max(frame_below(means, speed), ends[third - 1] + 1);
        ends[third] = std::min(ends[third], means.size() / 2 - 1);
    }
    range.reaches_flock = means[2 * ends.back()] <= plan.speed_flock;
    return range;
}

/// g, c and the rate at the flock speed; if the beads stay faster, only the mean rate over the observed speeds.
std::array<double, 3> fit_law(const DampingPlan& plan, const FitRange& range, std::span<const double> means) {
    const std::size_t last = range.ends.back();
    if (!range.reaches_flock) return {nan, nan, (means[0] - means[2 * last]) / (means[2 * last + 1] - means[1])};
    std::vector<double> distances, times, losses;
    for (std::size_t frame = 0; frame < last; ++frame) {
        losses.push_back(means[2 * frame] - means[2 * frame + 2]);
        distances.push_back(means[2 * frame + 3] - means[2 * frame + 1]);
        times.push_back(plan.frame);
    }
    const std::vector<double> fit = least_squares({distances, times}, losses);
    return {fit[0], fit[1], fit[0] + fit[1] / plan.speed_flock};
}

std::vector<double> estimates_of(const DampingPlan& plan, const FitRange& range, std::span<const double> means) {
    const auto [linear, coulomb, rate] = fit_law(plan, range, means);
    const auto& ends = range.ends;
    std::vector<double> values{rate, linear, coulomb, coulomb / plan.speed_flock / rate};
    for (std::size_t third = 0; third < 3; ++third) {
        const std::size_t a = 2 * ends[third], b = 2 * ends[third + 1];
        values.push_back((means[a] - means[b]) / (means[b + 1] - means[a + 1]));
    }
    return values;
}

std::string conclude(const DampingPlan& plan, std::vector<measure::Estimate>& estimates) {
    const measure::Estimate& share = estimates[3];
    constexpr double useful = 0.5;  // a share that is known worse tells nothing
    if (share.error && *share.error > useful) return "linearity of the damping in the speed is not known";
    if (!share.error)
        return text(
            "the beads did not slow down to {} mm/s: the rate is a mean over the observed speeds, and its linearity is "
            "not known",
            plan.speed_flock);
    const std::string detail = text("at {} mm/s a fraction {:.2g} +- {:.2g} of it is independent of the speed",
                                    plan.speed_flock, share.mean, *share.error);
    if (std::abs(share.mean) <= 2.0 * *share.error) return "the damping is linear within its error: " + detail;
    if (share.mean < 0.0) return "the damping is weaker than linear at low speeds: " + detail;
    return (share.mean > 0.5 ? "the damping is Coulomb-like: " : "the damping is linear with a Coulomb-like part: ") +
           detail;
}
}  // namespace

Assay damping(const DampingPlan& plan) {
    require(plan.speed > plan.speed_flock && plan.speed_flock > plan.min_speed && plan.min_speed > 0.0, {},
            "damping: min_speed, speed_flock, speed = {}, {}, {} mm/s; expected 0 < min_speed < speed_flock < speed",
            plan.min_speed, plan.speed_flock, plan.speed);
    require(plan.releases >= 1 && plan.frame > 0.0 && plan.time >= 4.0 * plan.frame, {},
            "damping: {} releases of {} s in frames of {} s; expected at least one release of at least four frames",
            plan.releases, plan.time, plan.frame);
    return {.name = "damping",
            .population = Population::beads,
            .quantities =
                {{"damping_rate", "1/s",
                  "Gamma/(m rho) = g + c/v at the flock speed v; a mean over the observed speeds if the remark says "
                  "so"},
                 {"damping_linear", "1/s", "g: dv/dt = -g v - c", false},
                 {"damping_coulomb", "mm/s^2", "c", false},
                 {"coulomb_share", "1", "(c/v)/(g + c/v) at the flock speed", false},
                 {"damping_rate_fast", "1/s", "-dv/dx, fastest third of the decade", false},
                 {"damping_rate_middle", "1/s", "-dv/dx, middle third", false},
                 {"damping_rate_slow", "1/s", "-dv/dx, slowest third", false}},
            .trial = std::bind_front(release, plan),
            .estimator =
                [plan](std::span<const Trial> trials) {
                    return std::bind_front(estimates_of, plan, fit_range(plan, trials));
                },
            .conclude = [plan](std::vector<measure::Estimate>& estimates) { return conclude(plan, estimates); }};
}

Rows<DampingPlan> DampingPlan::rows() {
    using Plan = DampingPlan;
    return Rows<DampingPlan>{
        {"speed", &Plan::speed, "initial bead speed at each release", "mm/s", positive},
        {"min_speed", &Plan::min_speed, "bead speed at which the fit of the decay ends: a decade below speed", "mm/s",
         positive},
        {"speed_flock", &Plan::speed_flock, "bead speed at which the rate is evaluated, between min_speed and speed",
         "mm/s", positive},
        {"warm_up", &Plan::warm_up, "once, at the start", "s", not_negative},
        {"hold", &Plan::hold, "before each release", "s", not_negative},
        {"releases", &Plan::releases, "per system, along x, y, -x, -y, and so on", "", within(1, 1000)},
        {"time", &Plan::time, "recorded after each release; until min_speed, about 3/(Gamma/(m rho))", "s", positive},
        {"frame", &Plan::frame, "between samples; a multiple of the plate period", "s", positive},
    };
}

}  // namespace drover::calibrate
