// calibrate/assays/scattering.cpp: alignment by contacts from collisions of two rods.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"
#include "dem/packing/packing.hpp"

namespace drover::calibrate {

namespace {
constexpr std::size_t angle_bins = 6, duration_bins = 8;  // relative angles 0 to pi; durations 0 to max_duration
/// What happens to a pair of unit vectors, for the four sums of J_kq that a hierarchy of two moments needs.
enum Moment { linear, saturation, second, excitation, moments };

/// Layout of a trial: time apart in each bin of angle; mean of cos and cos 2 of the turn of free rods in each bin of
/// duration, with the number of turns; and for each bin of both, the number of encounters, the incoming moments, and
/// the outgoing ones.
constexpr std::size_t turns = angle_bins, turn_numbers = 3, encounters = turns + turn_numbers * duration_bins,
                      encounter_numbers = 1 + 2 * moments,
                      cut = encounters + encounter_numbers * angle_bins * duration_bins, numbers = cut + 1;

constexpr std::size_t place_of(std::size_t angle, std::size_t duration) {
    return encounters + encounter_numbers * (angle * duration_bins + duration);
}

std::size_t angle_bin(double first, double second) {
    const double apart = std::abs(std::remainder(second - first, 2.0 * std::numbers::pi));
    return std::min(angle_bins - 1, static_cast<std::size_t>(apart / std::numbers::pi * double(angle_bins)));
}

/// Re sum_q (z_1'^k + z_2'^k) z_1^-q z_2^(q-k), both rods being alike, for the angles before and after.
std::array<double, moments> moments_of(const std::array<double, 2>& before, const std::array<double, 2>& after) {
    std::array<double, moments> sums{};
    for (const double out : after) {
        for (const auto& [one, other] : {std::pair{before[0], before[1]}, std::pair{before[1], before[0]}}) {
            sums[linear] += std::cos(out - one);
            sums[saturation] += std::cos(out - 2.0 * one + other);
            sums[second] += std::cos(2.0 * (out - one));
        }
        sums[excitation] += std::cos(2.0 * out - before[0] - before[1]);
    }
    return sums;
}

/// A frame of the pair.
struct Pair {
    std::array<double, 2> angles{};
    double apart = 0.0;  ///< distance of the centres, of the nearest images
};

std::size_t duration_bin(const ScatteringPlan& plan, std::size_t frames) {
    const double part = (static_cast<double>(frames) - 0.5) * plan.frame / plan.max_duration;
    return std::min(duration_bins - 1, static_cast<std::size_t>(part * double(duration_bins)));
}

void add_encounter(const ScatteringPlan& plan, const Pair& in, const Pair& out, std::size_t frames, Trial& trial) {
    double* at = &trial[place_of(angle_bin(in.angles[0], in.angles[1]), duration_bin(plan, frames))];
    const auto before = moments_of(in.angles, in.angles), after = moments_of(in.angles, out.angles);
    at[0] += 1.0;
    for (std::size_t m = 0; m < moments; ++m) at[1 + m] += before[m], at[1 + moments + m] += after[m];
}

/// Turns of rods that stay apart from frame `first` to `end`, at every lag.
void add_turns(const ScatteringPlan& plan, const std::vector<Pair>& path, std::size_t first, std::size_t end,
               Trial& trial) {
    const std::size_t longest = frames_in(plan.max_duration, plan.frame);
    for (std::size_t i = first; i < end; ++i)
        for (std::size_t lag = 1; lag <= longest && i + lag < end; ++lag) {
            double* at = &trial[turns + turn_numbers * duration_bin(plan, lag)];
            for (std::size_t rod = 0; rod < 2; ++rod) {
                const double turn = path[i + lag].angles[rod] - path[i].angles[rod];
                at[0] += 1.0, at[1] += std::cos(turn), at[2] += std::cos(2.0 * turn);
            }
        }
}

/// Encounters and free paths, in turn, of a pair.
Trial evaluated(const ScatteringPlan& plan, const std::vector<Pair>& path) {
    Trial trial(numbers, 0.0);
    const std::size_t longest = frames_in(plan.max_duration, plan.frame);
    const auto is_close = [&](std::size_t i) { return path[i].apart < plan.range; };
    for (std::size_t i = 0; i < path.size();) {
        std::size_t end = i;
        while (end < path.size() && is_close(end) == is_close(i)) ++end;
        if (!is_close(i)) {
            for (std::size_t k = i; k < end; ++k) trial[angle_bin(path[k].angles[0], path[k].angles[1])] += plan.frame;
            add_turns(plan, path, i, end, trial);
        } else if (i > 0 && (end < path.size() || end - i > longest)) {
            const std::size_t frames = std::min(end - i, longest);
            add_encounter(plan, path[i], path[i + frames], frames, trial);
            trial[cut] += end - i > longest ? 1.0 : 0.0;
        }
        i = end;
    }
    return trial;
}

/// Rejects encounters that would begin when the rods already touch.
void check_range(const ScatteringPlan& plan, const dem::Setup& setup, const Locate& locate) {
    // Sizes are normally distributed: the mean of a pair is larger once in 10^5 pairs.
    const double largest = 1.0 + 3.0 * setup.rods.size_tolerance;
    const dem::Shape shape = dem::rod_shape(setup.rods, largest, locate);
    const double touching = 2.0 * std::max(shape.head, -shape.tail);
    require(plan.range >= touching, locate("calibrate.scattering.range"),
            "scattering: encounters begin at a range of {} mm, where the centres of mass of two rods that touch can be "
            "{:.4g} mm apart; expected a larger range",
            plan.range, touching);
}

Trial follow(const ScatteringPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    dem::Setup setup = with_rods(given, false);
    setup.beads.count = static_cast<int>(
        std::lround(setup.beads.count * plan.cell * plan.cell / (setup.cell.lx * setup.cell.ly)));  // 0: by the area
    setup.cell.lx = setup.cell.ly = plan.cell;
    setup.rods.count = 2;
    const auto pair = [cell = plan.cell](const std::vector<RodPose>& rods) {
        return Pair{.angles = {rods[0].angle, rods[1].angle},
                    .apart = std::hypot(std::remainder(rods[1].x - rods[0].x, cell),
                                        std::remainder(rods[1].y - rods[0].y, cell))};
    };
    return evaluated(plan, mapped(rod_frames(plan, make, setup, seed), pair));
}

std::vector<double> estimates_of(const ScatteringPlan& plan, std::span<const double> means) {
    // Two rods that are apart are nowhere closer than the range.
    const double area = plan.cell * plan.cell - std::numbers::pi * plan.range * plan.range;
    std::array<std::array<double, moments>, angle_bins> kernel{};  // A times the rate of change of the moments
    double rate = 0.0, count = 0.0;
    for (std::size_t angle = 0; angle < angle_bins; ++angle) {
        const double apart = means[angle];
        for (std::size_t duration = 0; duration < duration_bins; ++duration) {
            const double* turned = &means[turns + turn_numbers * duration];
            const double* met = &means[place_of(angle, duration)];
            if (met[0] == 0.0) continue;
            for (std::size_t m = 0; m < moments; ++m) {
                const double kept = turned[m == linear || m == saturation ? 1 : 2] / turned[0];
                kernel[angle][m] += area * (met[1 + moments + m] / kept - met[1 + m]) / apart;
            }
            rate += area * met[0] / apart / double(angle_bins);
            count += met[0];
        }
    }
    if (count == 0.0) return std::vector<double>(7 + angle_bins, nan);  // no two rods met
    std::array<double, moments> mean{};
    for (const auto& one : kernel)
        for (std::size_t m = 0; m < moments; ++m) mean[m] += 0.5 * one[m] / double(angle_bins);
    const auto kept = [&](std::size_t duration) {
        return means[turns + turn_numbers * duration + 1] / means[turns + turn_numbers * duration];
    };
    constexpr std::size_t last = duration_bins - 1, middle = last / 2;
    const double between = plan.max_duration * double(last - middle) / double(duration_bins);
    std::vector<double> values{mean[linear],
                               mean[second],
                               mean[excitation],
                               -mean[saturation],
                               rate,
                               means[cut] / count,
                               std::log(kept(middle) / kept(last)) / between};
    for (const auto& one : kernel) values.push_back(0.5 * one[linear]);
    return values;
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    constexpr std::size_t share = 5;
    constexpr double many = 0.1;
    if (std::isnan(estimates[share].mean)) return "no two rods met: a longer time, or a smaller cell";
    if (!(estimates[share].mean > many)) return "";
    return text("{:.2g} of all encounters last longer than max_duration: collisions of pairs are not short events here",
                estimates[share].mean);
}
}  // namespace

Assay scattering(const ScatteringPlan& plan) {
    require(plan.cell > 2.0 * plan.range, {},
            "scattering: a cell of {} mm and a range of {} mm; expected a cell longer than twice the range: "
            "otherwise a rod would meet two images of the other",
            plan.cell, plan.range);
    require(plan.frame > 0.0 && plan.max_duration >= 2.0 * plan.frame && plan.time > plan.max_duration, {},
            "scattering: frames of {} s, encounters of at most {} s, a trial of {} s; expected at least two frames in "
            "an encounter, and a longer trial",
            plan.frame, plan.max_duration, plan.time);
    std::vector<Quantity> quantities{
        {"contact_scattering", "mm^2/s", "c = J_10 + J_11 of pairs of rods: d_t P = c sigma P"},
        {"scattering_second", "mm^2/s", "J_20 + J_22: d_t psi_2 = J sigma psi_2", false},
        {"scattering_excitation", "mm^2/s", "J_21: d_t psi_2 = J sigma psi_1^2", false},
        {"scattering_saturation", "mm^2/s", "-(J_12 + J_1,-1): d_t psi_1 = -s sigma psi_2 psi_1*", false},
        {"encounter_rate", "mm^2/s", "rate of encounters of a pair times the area of the cell", false},
        {"encounters_cut", "1", "share of encounters that last longer than max_duration", false},
        {"relaxation_apart", "1/s", "a of rods that are apart, over the longer half of the durations", false}};
    for (std::size_t angle = 0; angle < angle_bins; ++angle) {
        const auto degrees = static_cast<int>((2 * angle + 1) * 90 / angle_bins);
        quantities.push_back({text("contact_at_{}", degrees), "mm^2/s",
                              text("c of pairs {} +- {} degrees apart", degrees, 90 / angle_bins), false});
    }
    return {.name = "scattering",
            .population = Population::single_rods,
            .quantities = quantities,
            .trial = std::bind_front(follow, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = conclude,
            .check = std::bind_front(check_range, plan)};
}

Rows<ScatteringPlan> ScatteringPlan::rows() {
    using Plan = ScatteringPlan;
    return Rows<ScatteringPlan>{
        {"cell", &Plan::cell, "side of the periodic square with two rods; more than twice the range", "mm", positive},
        {"range", &Plan::range, "distance of centres at which an encounter begins and ends; rods must not touch there",
         "mm", positive},
        {"max_duration", &Plan::max_duration, "longer encounters are cut off there; well below 1/a", "s", positive},
        {"warm_up", &Plan::warm_up, "once, in random directions", "s", not_negative},
        {"time", &Plan::time, "of a trial, from warm_up on", "s", positive},
        {"frame", &Plan::frame, "between samples of the positions; short compared to an encounter", "s", positive},
    };
}

}  // namespace drover::calibrate
