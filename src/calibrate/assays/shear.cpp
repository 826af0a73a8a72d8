// calibrate/assays/shear.cpp: shear viscosity of the beads.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
/// Amplitudes after 0, 1, ... frames of one wave after the other, averaged over releases; then q^2 of each wave.
Trial release(const ShearPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    dem::Setup setup = beads_alone(given);
    setup.forces = {.hold_beads = true};
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    const std::size_t frames = frames_in(plan.time, plan.frame);
    Trial trial;
    for (const double number : plan.waves) {
        const int waves = static_cast<int>(number);
        std::vector<double> amplitude(frames + 1, 0.0);
        for (int i = 0; i < plan.releases; ++i) {
            const double side = i % 2 == 0 ? 1.0 : -1.0;
            system->impose({.hold_beads = true, .bead_velocity_x = side * plan.speed, .held_waves = waves});
            system->advance_to(time += plan.hold);
            system->impose({});
            for (std::size_t frame = 0; frame <= frames; ++frame) {
                system->advance_to(time + static_cast<double>(frame) * plan.frame);
                amplitude[frame] += side * system->shear_wave(waves) / plan.releases;
            }
            time += static_cast<double>(frames) * plan.frame;
        }
        trial.insert(trial.end(), amplitude.begin(), amplitude.end());
    }
    for (const double waves : plan.waves) trial.push_back(std::pow(2.0 * std::numbers::pi * waves / setup.cell.ly, 2));
    return trial;
}

double rate_of(std::span<const double> amplitude, double frame) {
    double trapezoids = 0.0;
    for (std::size_t i = 1; i < amplitude.size(); ++i) trapezoids += 0.5 * frame * (amplitude[i - 1] + amplitude[i]);
    return 2.0 / frame * std::atanh(0.5 * frame * (amplitude.front() - amplitude.back()) / trapezoids);
}

std::vector<double> estimates_of(const ShearPlan& plan, const std::vector<std::size_t>& ends,
                                 std::span<const double> means) {
    const std::size_t waves = plan.waves.size(), length = frames_in(plan.time, plan.frame) + 1;
    std::vector<double> rates, weights;
    const std::span<const double> squares = means.subspan(waves * length);
    for (std::size_t k = 0; k < waves; ++k) {
        rates.push_back(rate_of(means.subspan(k * length, ends[k] + 1), plan.frame));
        weights.push_back(1.0 / (rates.back() * rates.back()));
    }
    const Line line = fit_line(squares, rates, weights);
    // Two points always lie on a line.
    double bend = waves > 2 ? 0.0 : nan;
    for (std::size_t k = 0; waves > 2 && k < waves; ++k) {
        const double residual = (rates[k] - line.at_zero - line.slope * squares[k]) / rates[k];
        if (std::abs(residual) > std::abs(bend)) bend = residual;
    }
    std::vector<double> values{line.slope, line.at_zero, bend};
    values.insert(values.end(), rates.begin(), rates.end());
    return values;
}

/// The last frame of each fit, from all trials.
std::vector<std::size_t> ends_of(const ShearPlan& plan, std::span<const Trial> trials) {
    const std::vector<double> means = means_over(trials);
    const std::size_t length = frames_in(plan.time, plan.frame) + 1;
    std::vector<std::size_t> ends;
    for (std::size_t k = 0; k < plan.waves.size(); ++k) {
        std::size_t end = 1;
        while (end + 1 < length && means[k * length + end] >= plan.min_fraction * means[k * length]) ++end;
        ends.push_back(end);
    }
    return ends;
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    const measure::Estimate& bend = estimates[2];
    if (!bend.error) return "linearity of the rates in q^2 is not known";
    if (std::abs(bend.mean) <= 2.5 * *bend.error) return "the rates are linear in q^2 within their errors";
    return text("the rates are not linear in q^2: largest relative residual {:.2g}", std::abs(bend.mean));
}
}  // namespace

Assay shear(const ShearPlan& plan) {
    require(plan.waves.size() >= 2 && plan.waves.front() >= 1 && is_ascending(plan.waves) &&
                std::ranges::all_of(plan.waves, [](double k) { return k == std::floor(k); }),
            {}, "shear: expected at least two integer numbers of waves, > 0 and ascending");
    require(plan.releases >= 1 && plan.frame > 0.0 && plan.time >= 4.0 * plan.frame, {},
            "shear: {} releases of {} s in frames of {} s; expected at least one release of at least four frames",
            plan.releases, plan.time, plan.frame);
    std::vector<Quantity> quantities{{"viscosity_kinematic", "mm^2/s", "eta/(m rho): r = (Gamma + eta q^2)/(m rho)"},
                                     {"damping_intercept", "1/s", "Gamma/(m rho): r at q = 0", false},
                                     {"shear_bend", "1", "largest (r - line)/r, of three or more waves", false}};
    for (const double waves : plan.waves)
        quantities.push_back({text("shear_rate_{}", waves), "1/s", text("r of {} waves", waves), false});
    return {.name = "shear",
            .population = Population::beads,
            .quantities = quantities,
            .trial = std::bind_front(release, plan),
            .estimator =
                [plan](std::span<const Trial> trials) {
                    return std::bind_front(estimates_of, plan, ends_of(plan, trials));
                },
            .conclude = conclude};
}

Rows<ShearPlan> ShearPlan::rows() {
    using Plan = ShearPlan;
    return Rows<ShearPlan>{
        {"waves", &Plan::waves, "across the cell, integers, ascending: q = 2 pi waves/ly", "", within(1, 1000)},
        {"speed", &Plan::speed, "initial amplitude at each release", "mm/s", positive},
        {"min_fraction",
         &Plan::min_fraction,
         "of the initial amplitude, at which the fit of the decay ends",
         "",
         {.min = 0.0, .max = 0.99, .min_open = true}},
        {"warm_up", &Plan::warm_up, "once, at the start", "s", not_negative},
        {"hold", &Plan::hold, "before each release", "s", not_negative},
        {"releases", &Plan::releases, "of each wave, with alternating sign", "", within(1, 1000)},
        {"time", &Plan::time, "recorded after each release", "s", positive},
        {"frame", &Plan::frame, "between samples; a multiple of the plate period", "s", positive},
    };
}

}  // namespace drover::calibrate
