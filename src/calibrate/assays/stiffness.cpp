// calibrate/assays/stiffness.cpp: response of the bead density to a force.
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
constexpr double min_errors = 3.0;  // of a significant response

/// Amplitude d of the rod density sigma (1 + d cos(q x)).
double density_wave_of_rods(const std::vector<RodPose>& rods, double q) {
    double sum = 0.0;
    for (const RodPose& rod : rods) sum += std::cos(q * rod.x);
    return 2.0 * sum / static_cast<double>(rods.size());
}

/// -d of the beads under each force, averaged over both signs; q; among rods also -d of the rods.
Trial push(const StiffnessPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    require_beads(given, "stiffness");
    dem::Setup setup = plan.among_rods ? with_rods(given, false) : beads_alone(given);
    dem::BodyForces forces;
    if (plan.among_rods) forces = {.torque = plan.torque, .angle = 0.5 * std::numbers::pi};
    setup.forces = forces;
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    const std::size_t frames = frames_in(plan.time, plan.frame), levels = plan.pushes.size();
    const double q = 2.0 * std::numbers::pi * plan.waves / setup.cell.lx;
    Trial trial(plan.among_rods ? 2 * levels + 1 : levels + 1, 0.0);
    trial[levels] = q;
    for (std::size_t level = 0; level < levels; ++level)
        for (const double side : {1.0, -1.0}) {
            forces.push = side * plan.pushes[level];
            forces.push_waves = plan.waves;
            system->impose(forces);
            system->advance_to(time += plan.settle);
            const double weight = -0.5 * side / static_cast<double>(frames);
            for (std::size_t frame = 0; frame < frames; ++frame) {
                system->advance_to(time += plan.frame);
                trial[level] += weight * system->density_wave(plan.waves);
                if (plan.among_rods) trial[levels + 1 + level] += weight * density_wave_of_rods(system->rods(), q);
            }
        }
    return trial;
}

std::vector<double> estimates_of(const StiffnessPlan& plan, std::span<const double> means) {
    const double low = plan.pushes[0], high = plan.pushes[1];
    const auto slope = [&](std::size_t first) {
        return (low * means[first] + high * means[first + 1]) / (low * low + high * high);
    };
    std::vector<double> values{1.0 / (means[2] * slope(0)), slope(0), means[1] / means[0] * low / high};
    if (plan.among_rods) values.push_back(slope(3) / slope(0));
    return values;
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    measure::Estimate& modulus = estimates[0];
    const measure::Estimate &response = estimates[1], &ratio = estimates[2];
    if (!response.error || std::abs(response.mean) < min_errors * *response.error) {
        modulus.mean = nan;
        modulus.error.reset();
        modulus.why_no_error =
            "the density response does not exceed its fluctuations: use larger forces (pushes) or a longer time";
        return "not available: " + modulus.why_no_error;
    }
    constexpr double useful = 0.5;  // a ratio that is known worse tells nothing
    if (!ratio.error || *ratio.error > useful) return "linearity of the density response is not known";
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
    require(!plan.among_rods || plan.torque > 0.0, {}, "stiffness: torque = {} among rods; expected > 0", plan.torque);
    std::vector<Quantity> quantities{{"stiffness", "mg mm^2/s^2", "E = f/(q d), density rho (1 - d cos(qx))"},
                                     {"density_response", "s^2/(mg mm)", "d/f", false},
                                     {"response_ratio", "1", "(d/f at the larger f)/(d/f at the smaller)", false}};
    if (plan.among_rods) quantities.push_back({"rods_follow", "1", "d of the rods over d of the beads", false});
    return {.name = "stiffness",
            .population = plan.among_rods ? Population::all : Population::beads,
            .quantities = quantities,
            .trial = std::bind_front(push, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = conclude};
}

Rows<StiffnessPlan> StiffnessPlan::rows() {
    using Plan = StiffnessPlan;
    return Rows<StiffnessPlan>{
        {"waves", &Plan::waves, "of the force across the cell", "", within(1, 1000)},
        {"pushes", &Plan::pushes, "two force amplitudes on a bead, ascending", "mg mm/s^2", positive},
        {"among_rods", &Plan::among_rods,
         "with the rods of the setup, at each of their area fractions; false: beads alone"},
        {"torque", &Plan::torque, "among rods: of the field that holds their directions across the force",
         "mg mm^2/s^2", positive},
        {"warm_up", &Plan::warm_up, "once, at the start", "s", not_negative},
        {"settle", &Plan::settle,
         "after each change of the force, until sound has decayed: about 4 m rho/(Gamma + eta q^2)", "s", not_negative},
        {"time", &Plan::time, "averaged under each force", "s", positive},
        {"frame", &Plan::frame, "between samples", "s", positive},
    };
}

}  // namespace drover::calibrate
