// calibrate/assays/alignment_assay.cpp: alignment of rods by contacts, without the flow that they drive.
#include <cmath>

#include "calibrate/alignment.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
constexpr std::size_t numbers =
    4;  // per window: d_t P, <P>, <1 - C2>, <P (1 - C2) - P_y S2>, all of components along x

/// Means over rods of cos and sin of the angle and of twice the angle.
struct Moments {
    double cos = 0.0, sin = 0.0, cos_twice = 0.0, sin_twice = 0.0;
};
Moments moments_of(const std::vector<RodPose>& rods) {
    Moments sum;
    const double part = 1.0 / static_cast<double>(rods.size());
    for (const RodPose& rod : rods) {
        sum.cos += part * std::cos(rod.angle), sum.sin += part * std::sin(rod.angle);
        sum.cos_twice += part * std::cos(2.0 * rod.angle), sum.sin_twice += part * std::sin(2.0 * rod.angle);
    }
    return sum;
}

void watch(ParticleSystem& system, double& time, const AlignmentPlan& plan, double* out) {
    const std::size_t frames = frames_in(plan.time / plan.windows, plan.frame);
    const double fraction = 1.0 / static_cast<double>(frames);
    double first = 0.0, last = 0.0;
    for (std::size_t frame = 0; frame <= frames; ++frame) {
        if (frame > 0) system.advance_to(time += plan.frame);
        const Moments m = moments_of(system.rods());
        const double weight = frame == 0 || frame == frames ? 0.5 * fraction : fraction;
        if (frame == 0) first = m.cos;
        last = m.cos;
        out[1] += weight * m.cos;
        out[2] += weight * (1.0 - m.cos_twice);
        out[3] += weight * (m.cos * (1.0 - m.cos_twice) - m.sin * m.sin_twice);
    }
    out[0] = (last - first) / (plan.frame * static_cast<double>(frames));
}

/// Windows of each field, the weakest first.
Trial align_rods(const AlignmentPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    dem::Setup setup = with_rods(given, false);
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    const auto windows = static_cast<std::size_t>(plan.windows);
    Trial trial(numbers * windows * plan.torques.size(), 0.0);
    for (std::size_t k = 0; k < plan.torques.size(); ++k) {
        dem::BodyForces forces = setup.forces;
        forces.torque = plan.torques[k];
        system->impose(forces);
        for (std::size_t w = 0; w < windows; ++w) watch(*system, time, plan, &trial[numbers * (windows * k + w)]);
    }
    return trial;
}

std::vector<double> estimates_of(const AlignmentPlan& plan, std::span<const double> means) {
    const std::size_t windows = means.size() / numbers, each = windows / plan.torques.size();
    std::vector<double> change, order, pulled, shared;
    for (std::size_t w = 0; w < windows; ++w) {
        const double* of = &means[numbers * w];
        change.push_back(of[0]);
        order.push_back(of[1]);
        pulled.push_back(0.5 * plan.torques[w / each] * of[2]);
        shared.push_back(of[3]);
    }
    const std::vector<double> steady = least_squares({shared, pulled}, change),
                              slope = least_squares({shared, pulled}, order);
    std::vector<double> less = order;
    for (double& one : less) one = -one;
    const std::vector<double> all = least_squares({shared, pulled, less}, change);
    std::vector<double> values{steady[0] + reference_rate * slope[0], steady[0], slope[0], all[2],
                               steady[1] + reference_rate * slope[1]};
    for (std::size_t k = 1; k <= plan.torques.size(); ++k) values.push_back(order[k * each - 1]);
    return values;
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    const double lowest = estimates[5].mean;
    constexpr double weak = 0.4;
    if (lowest <= weak) return "";
    return text("P = {:.2g} in the weakest field: use one with P < {}", lowest, weak);
}
}  // namespace

Assay alignment(const AlignmentPlan& plan) {
    require(plan.torques.size() >= 2 && plan.torques.front() > 0.0 && is_ascending(plan.torques), {},
            "alignment: expected at least two torques, > 0 and ascending");
    require(plan.windows >= 1 && plan.frame > 0.0 && plan.time >= plan.frame * plan.windows, {},
            "alignment: {} s in {} windows and frames of {} s; expected at least one window of at least one frame",
            plan.time, plan.windows, plan.frame);
    std::vector<Quantity> quantities{{"contact_reference", "1/s", "c sigma at a = 0.1/s"},
                                     {"contact_steady", "1/s", "c sigma at a = 0", false},
                                     {"contact_slope", "1", "d(c sigma)/da", false},
                                     {"relaxation_among_rods", "1/s", "a, with c sigma and mu from the same fit",
                                      false},
                                     {"orienting_mobility", "s/(mg mm^2)", "mu at a = 0.1/s", false}};
    for (const double torque : plan.torques)
        quantities.push_back({text("order_held_{}", torque), "1", text("<P> at torque {}, beads held", torque), false});
    return {.name = "alignment",
            .population = Population::all,
            .quantities = quantities,
            .trial = std::bind_front(align_rods, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = conclude};
}

Rows<AlignmentPlan> AlignmentPlan::rows() {
    using Plan = AlignmentPlan;
    return Rows<AlignmentPlan>{
        {"torques", &Plan::torques, "of the orienting field, ascending; for P from below .4 to .9", "mg mm^2/s^2",
         positive},
        {"warm_up", &Plan::warm_up, "once, without a field", "s", not_negative},
        {"time", &Plan::time, "in each field", "s", positive},
        {"windows", &Plan::windows, "of equal length in that time", "", within(1, 1000)},
        {"frame", &Plan::frame, "between samples of P", "s", positive},
    };
}

}  // namespace drover::calibrate
