// calibrate/assays/weathercock.cpp: rotation of rods by bead flow.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
/// Means over rods, over the window of one release.
struct Turn {
    double angle = 0.0;       ///< change of theta [rad]
    double transverse = 0.0;  ///< integral of cos theta [s]
};

Turn record_turn(ParticleSystem& system, double start, double window, double max_frame) {
    const auto frames = static_cast<std::size_t>(std::max(4.0, std::ceil(window / max_frame - 1e-9)));
    const double frame = window / static_cast<double>(frames);
    std::vector<RodPose> before = system.rods();
    const double rods = static_cast<double>(before.size());
    Turn turn;
    for (std::size_t i = 1; i <= frames; ++i) {
        system.advance_to(start + static_cast<double>(i) * frame);
        const std::vector<RodPose> now = system.rods();
        for (std::size_t r = 0; r < now.size(); ++r) {
            turn.angle += std::remainder(now[r].angle - before[r].angle, 2.0 * std::numbers::pi) / rods;
            turn.transverse += 0.5 * frame * (std::cos(before[r].angle) + std::cos(now[r].angle)) / rods;
        }
        before = now;
    }
    return turn;
}

/// For each speed: rotation towards the flow and v int cos theta dt, both averaged over the mirror pair.
Trial turn_rods(const WeathercockPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    require_beads(given, "weathercock");
    dem::Setup setup = with_rods(given, true);
    setup.forces = {.torque = plan.torque, .hold_beads = true};
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    Trial trial;
    for (const double speed : plan.speeds) {
        double angle = 0.0, transverse = 0.0;
        for (const double side : {1.0, -1.0}) {
            dem::BodyForces forces{.torque = plan.torque, .hold_beads = true, .bead_velocity_y = side * speed};
            system->impose(forces);
            system->advance_to(time += plan.align);
            forces.torque = 0.0;
            system->impose(forces);
            system->advance_to(time += plan.settle);
            const double window = std::min(plan.distance / speed, plan.max_window);
            const Turn turn = record_turn(*system, time, window, plan.frame);
            time += window;
            angle += 0.5 * side * turn.angle;
            transverse += 0.5 * speed * turn.transverse;
        }
        trial.push_back(angle);
        trial.push_back(transverse);
    }
    return trial;
}

std::vector<double> estimates_of(const std::vector<double>& speeds, std::span<const double> means) {
    double turned = 0.0, transverse = 0.0;
    std::vector<double> logarithms, singles;
    for (std::size_t k = 0; k < speeds.size(); ++k) {
        turned += speeds[k] * means[2 * k];
        transverse += speeds[k] * means[2 * k + 1];
        logarithms.push_back(std::log(speeds[k]));
        singles.push_back(means[2 * k] / means[2 * k + 1]);
    }
    const double single = turned / transverse;
    const double exponent = 1.0 + fit_line(logarithms, singles, speeds).slope / single;
    std::vector<double> values{single, 0.5 * single, exponent};
    values.insert(values.end(), singles.begin(), singles.end());
    return values;
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    const measure::Estimate& exponent = estimates[2];
    constexpr double useful = 0.5;  // an exponent that is known worse tells nothing
    if (!exponent.error || *exponent.error > useful)
        return "linearity of the turning rate in the flow speed is not known";
    const bool linear = std::abs(exponent.mean - 1.0) <= 2.0 * *exponent.error;
    return text("the turning rate {} the flow speed: exponent {:.3g} +- {:.2g}",
                linear ? "is linear in" : "is not linear in", exponent.mean, *exponent.error);
}
}  // namespace

Assay weathercock(const WeathercockPlan& plan) {
    require(plan.speeds.size() >= 2 && plan.speeds.front() > 0.0 && is_ascending(plan.speeds), {},
            "weathercock: expected at least two speeds, > 0 and ascending");
    std::vector<Quantity> quantities{{"weathercock_single", "1/mm",
                                      "lambda_s: d theta/dt = lambda_s v sin(angle of v - theta)"},
                                     {"weathercock", "1/mm", "lambda = lambda_s/2"},
                                     {"turning_exponent", "1", "x: the turning rate goes as v^x", false}};
    for (const double speed : plan.speeds)
        quantities.push_back({text("weathercock_single_{}", speed), "1/mm", text("lambda_s at {} mm/s", speed), false});
    return {.name = "weathercock",
            .population = Population::single_rods,
            .quantities = quantities,
            .trial = std::bind_front(turn_rods, plan),
            .estimator = always(std::bind_front(estimates_of, plan.speeds)),
            .conclude = conclude};
}

Rows<WeathercockPlan> WeathercockPlan::rows() {
    using Plan = WeathercockPlan;
    return Rows<WeathercockPlan>{
        {"speeds", &Plan::speeds, "of the bead flow, ascending", "mm/s", positive},
        {"distance", &Plan::distance, "of the flow while rods turn: at most about 1/lambda_s", "mm", positive},
        {"max_window", &Plan::max_window, "longest time for that distance; slow flows go less far", "s", positive},
        {"torque", &Plan::torque,
         "that holds rods transverse to the flow before the release; stronger than that of the flow", "mg mm^2/s^2",
         positive},
        {"warm_up", &Plan::warm_up, "once, at the start", "s", not_negative},
        {"align", &Plan::align, "before each release", "s", not_negative},
        {"settle", &Plan::settle, "after each release, until the angular velocity follows the flow", "s", not_negative},
        {"frame", &Plan::frame, "longest time between samples", "s", positive},
    };
}

}  // namespace drover::calibrate
