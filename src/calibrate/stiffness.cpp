// calibrate/stiffness.cpp: response of the bead density to a force.
#include "drover/calibrate/stiffness.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "calibrate/plan_support.hpp"

namespace drover::calibrate {

namespace {
constexpr double min_errors = 3.0;  // of a significant response

/// -d under each force, averaged over both signs; then q.
Trial push(const StiffnessPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    require_beads(given, "stiffness");
    const dem::Setup setup = beads_alone(given);
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    const std::size_t frames = frames_in(plan.time, plan.frame);
    Trial trial;
    for (const double force : plan.pushes) {
        double response = 0.0;
        for (const double side : {1.0, -1.0}) {
            system->impose({.push = side * force, .push_waves = plan.waves});
            system->advance_to(time += plan.settle);
            for (std::size_t frame = 0; frame < frames; ++frame) {
                system->advance_to(time += plan.frame);
                response -= 0.5 * side * system->density_wave(plan.waves) / static_cast<double>(frames);
            }
        }
        trial.push_back(response);
    }
    trial.push_back(2.0 * std::numbers::pi * plan.waves / setup.cell.lx);
    return trial;
}

std::vector<double> estimates_of(const std::vector<double>& pushes, std::span<const double> means) {
    const double response =
        (pushes[0] * means[0] + pushes[1] * means[1]) / (pushes[0] * pushes[0] + pushes[1] * pushes[1]);
    return {1.0 / (means[2] * response), response, means[1] / means[0] * pushes[0] / pushes[1]};
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    measure::Estimate& modulus = estimates[0];
    const measure::Estimate &response = estimates[1], &ratio = estimates[2];
    if (!response.error || std::abs(response.mean) < min_errors * *response.error) {
        modulus.mean = std::numeric_limits<double>::quiet_NaN();
        modulus.error.reset();
        modulus.refusal =
            "the density response does not exceed its fluctuations: use larger forces (pushes) or a longer time";
        return "not available: " + modulus.refusal;
    }
    if (!ratio.error) return "linearity of the density response is not known";
    const bool linear = std::abs(ratio.mean - 1.0) <= 2.0 * *ratio.error;
    return text(
        "the density response is {} in the force: d/f at the larger force is {:.3g} +- {:.2g} times that at the "
        "smaller",
        linear ? "linear" : "not linear", ratio.mean, *ratio.error);
}
}  // namespace

Assay stiffness(const StiffnessPlan& plan) {
    require(plan.pushes.size() == 2 && plan.pushes[0] > 0.0 && plan.pushes[1] > plan.pushes[0], {},
            "stiffness: expected two force amplitudes (pushes), > 0 and ascending");
    return {.name = "stiffness",
            .population = Population::beads,
            .quantities = {{"stiffness", "mg mm^2/s^2", "E = f/(q d), density rho (1 - d cos(qx))"},
                           {"density_response", "s^2/(mg mm)", "d/f", false},
                           {"response_ratio", "1", "(d/f at the larger f)/(d/f at the smaller)", false}},
            .trial = std::bind_front(push, plan),
            .estimator = always(std::bind_front(estimates_of, plan.pushes)),
            .conclude = conclude};
}

}  // namespace drover::calibrate

namespace drover {

template <>
const std::vector<Row<calibrate::StiffnessPlan>>& schema<calibrate::StiffnessPlan>() {
    using Plan = calibrate::StiffnessPlan;
    static const std::vector<Row<Plan>> rows{
        {.name = "waves",
         .member = &Plan::waves,
         .range = {.min = 1, .max = 1000},
         .doc = "of the force across the cell"},
        {.name = "pushes",
         .member = &Plan::pushes,
         .unit = "mg mm/s^2",
         .range = positive,
         .doc = "two force amplitudes on a bead, ascending"},
        {.name = "warm_up", .member = &Plan::warm_up, .unit = "s", .range = not_negative, .doc = "once, at the start"},
        {.name = "settle",
         .member = &Plan::settle,
         .unit = "s",
         .range = not_negative,
         .doc = "after each change of the force, until sound has decayed: about 4 m rho/(Gamma + eta q^2)"},
        {.name = "time", .member = &Plan::time, .unit = "s", .range = positive, .doc = "averaged under each force"},
        {.name = "frame", .member = &Plan::frame, .unit = "s", .range = positive, .doc = "between samples"}};
    return rows;
}

}  // namespace drover
