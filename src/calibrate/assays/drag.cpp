// calibrate/assays/drag.cpp: speed at which aligned rods drag the beads.
#include <cmath>
#include <numbers>

#include "calibrate/alignment.hpp"
#include "calibrate/assays/plan_support.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
constexpr std::size_t numbers = 4;  // per window: <v>, <P>, <|P|^2 P>, [v(T) - v(0)]/T, all along x

/// Polar order of the rods: its x component and its square.
struct Order {
    double along = 0.0, square = 0.0;
};
Order order_of(const std::vector<RodPose>& rods) {
    double along = 0.0, across = 0.0;
    for (const RodPose& rod : rods) along += std::cos(rod.angle), across += std::sin(rod.angle);
    const double count = static_cast<double>(rods.size());
    return {along / count, (along * along + across * across) / (count * count)};
}

std::size_t frames_of(const DragPlan& plan) { return frames_in(plan.time / plan.windows, plan.frame); }
double window_of(const DragPlan& plan) { return plan.frame * static_cast<double>(frames_of(plan)); }

void watch(ParticleSystem& system, double& time, const DragPlan& plan, double* out) {
    const std::size_t frames = frames_of(plan);
    const double fraction = 1.0 / static_cast<double>(frames), window = window_of(plan);
    const BeadMotion start = system.beads();
    for (std::size_t frame = 0; frame <= frames; ++frame) {
        if (frame > 0) system.advance_to(time += plan.frame);
        const Order order = order_of(system.rods());
        const double weight = frame == 0 || frame == frames ? 0.5 * fraction : fraction;
        out[1] += weight * order.along;
        out[2] += weight * order.square * order.along;
    }
    const BeadMotion end = system.beads();
    out[0] = (end.x - start.x) / window;
    out[3] = (end.vx - start.vx) / window;
}

/// Windows of each torque, the strongest first.  Rods start along x and beads at rest: the growth of flow gives tau.
Trial drag_beads(const DragPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    require_beads(given, "drag");
    dem::Setup setup = with_rods(given, true);
    setup.forces = {.torque = plan.torques.back()};
    const auto system = make(setup, seed);
    double time = plan.warm_up;
    system->advance_to(time);
    const auto windows = static_cast<std::size_t>(plan.windows);
    Trial trial(numbers * windows * plan.torques.size(), 0.0);
    for (std::size_t k = plan.torques.size(); k-- > 0;) {
        const double torque = plan.torques[k];
        system->impose({.torque = std::abs(torque), .angle = torque < 0.0 ? std::numbers::pi : 0.0});
        for (std::size_t w = 0; w < windows; ++w) watch(*system, time, plan, &trial[numbers * (windows * k + w)]);
    }
    return trial;
}

/// The first torque along x; a reversal comes before it.
std::size_t first_along(const DragPlan& plan) { return plan.torques.front() < 0.0 ? 1 : 0; }

/// alpha/Gamma of the straight line through the windows in which the field does not turn the rods round.
double straight_where_aligned(const DragPlan& plan, const std::vector<std::vector<double>>& columns,
                              const std::vector<double>& flow) {
    const auto first = static_cast<std::ptrdiff_t>(first_along(plan) * flow.size() / plan.torques.size());
    const auto along = [&](const std::vector<double>& all) {
        return std::vector<double>(all.begin() + first, all.end());
    };
    return least_squares({along(columns[0]), along(columns[2])}, along(flow))[0];
}

/// g as a function of the rate: steady + drift/a.  Midpoints of neighbouring windows, weighted by dP/dkappa (errors of
/// P are equal).  The equation is that for the mean of exp(i theta) with its second harmonic closed by a von Mises
/// distribution; exact in a steady state and for many rods.  The rate a is not fitted: noise of d_t P would bias it,
/// and with it g.
struct AlignmentFit {
    std::vector<double> order, torque, concentration, lag;  ///< weighted, of each midpoint

    /// change: d_t P
    void add(double of_torque, double of_order, double change) {
        const double kappa = concentration_of_order(of_order);
        constexpr double small = 1e-6;
        const double ratio = std::abs(of_order) < small ? 2.0 : kappa / of_order;
        const double weight = 1.0 - 1.0 / ratio - of_order * of_order;  // dP/dkappa
        order.push_back(weight * of_order);
        torque.push_back(weight * of_torque);
        concentration.push_back(weight * kappa);
        lag.push_back(weight * ratio * change);
    }
    double steady() const { return least_squares({order, torque}, concentration)[0]; }  ///< with d_t P left out
    double drift() const { return least_squares({order, torque}, lag)[0]; }             ///< by 1/a [1/s]
};

std::vector<double> estimates_of(const DragPlan& plan, std::span<const double> means) {
    const std::size_t torques = plan.torques.size();
    std::vector<std::vector<double>> columns(numbers - 1);
    std::vector<double> flow;
    const std::size_t windows = means.size() / numbers;
    for (std::size_t w = 0; w < windows; ++w) {
        flow.push_back(means[numbers * w]);
        for (std::size_t i = 1; i < numbers; ++i) columns[i - 1].push_back(means[numbers * w + i]);
    }
    const std::vector<double> curved = least_squares(columns, flow),
                              straight = least_squares({columns[0], columns[2]}, flow);
    const double slope = plan.bend ? curved[0] : straight[0], tau = plan.bend ? -curved[2] : -straight[1];
    std::vector<double> values{slope, curved[1], tau};
    const std::size_t each = windows / torques;
    AlignmentFit fit;
    for (std::size_t k = first_along(plan); k < torques; ++k) {
        const std::span<const double> orders(&columns[0][k * each], each);
        if (each == 1) fit.add(plan.torques[k], orders[0], 0.0);
        for (std::size_t w = 1; w < each; ++w)
            fit.add(plan.torques[k], 0.5 * (orders[w - 1] + orders[w]), (orders[w] - orders[w - 1]) / window_of(plan));
    }
    const double steady = fit.steady(), drift = fit.drift();
    values.insert(values.end(), {steady, drift, steady + reference_time * drift});
    for (std::size_t k = 1; k <= torques; ++k) {
        const std::size_t last = k * windows / torques - 1;
        values.push_back(columns[0][last]);
        values.push_back(flow[last]);
    }
    if (plan.bend) values.push_back(straight_where_aligned(plan, columns, flow));
    return values;
}

std::string conclude(const DragPlan& plan, std::vector<measure::Estimate>& estimates) {
    const measure::Estimate &slope = estimates[0], &bend = estimates[1];
    constexpr double useful = 1.0;  // of the slope: a bend that is known worse tells nothing
    if (!slope.error || !bend.error || *bend.error > useful * std::abs(slope.mean))
        return "linearity of the flow in the order is not known";
    if (std::abs(bend.mean) <= 2.0 * *bend.error)
        return text("the flow is linear in the order, to {:.2g} of its slope at P = 1",
                    *bend.error / std::abs(slope.mean));
    if (!plan.bend)
        return text(
            "the flow is not linear in the order but a straight line was fitted: the term {:.2g} +- {:.2g} |P|^2 P "
            "was omitted",
            bend.mean, *bend.error);
    return text("the flow is not linear in the order: at P = 1 it is {:.3g} times its slope at P = 0",
                1.0 + bend.mean / slope.mean);
}
}  // namespace

Assay drag(const DragPlan& plan) {
    require(!plan.torques.empty(), {}, "drag: expected at least two torques > 0");
    const std::size_t along = plan.torques.size() - first_along(plan);
    require(along >= 2 && plan.torques[plan.torques.size() - along] > 0.0 && is_ascending(plan.torques), {},
            "drag: expected at least two torques > 0, ascending, and before them at most one < 0");
    require(plan.windows >= 1 && plan.frame > 0.0 && plan.time >= plan.frame * plan.windows, {},
            "drag: {} s in {} windows and frames of {} s; expected at least one window of at least one frame",
            plan.time, plan.windows, plan.frame);
    constexpr std::size_t unknowns = numbers - 1;
    require(
        plan.torques.size() * static_cast<std::size_t>(plan.windows) >= unknowns, {},
        "drag: {} torques with {} windows each; expected at least {} windows in all to fit slope, curvature and tau",
        plan.torques.size(), plan.windows, unknowns);
    std::vector<Quantity> quantities{{"drag", "mm/s", "alpha/Gamma: v = (alpha/Gamma) P + c |P|^2 P"},
                                     {"drag_curvature", "mm/s", "c", false},
                                     {"response_time", "s", "tau = m rho/Gamma, with rods among the beads", false},
                                     {"alignment_steady", "1",
                                      "g at 1/a = 0: kappa = g P + beta T, P = I1(kappa)/I0(kappa)", false},
                                     {"alignment_drift", "1/s", "dg/d(1/a): kappa [1 + d_t P/(a P)] = g P + beta T",
                                      false},
                                     {"alignment_reference", "1", "g at 1/a = 10 s", false}};
    for (const double torque : plan.torques) {
        quantities.push_back({text("order_{}", torque), "1", text("<P> at torque {}", torque), false});
        quantities.push_back({text("flow_{}", torque), "mm/s", text("<v> at torque {}", torque), false});
    }
    if (plan.bend) {
        quantities[1].name = "drag_cubic";
        quantities.push_back({"drag_straight", "mm/s", "alpha/Gamma of a straight line, at torques > 0", false});
    }
    return {.name = "drag",
            .population = Population::all,
            .quantities = quantities,
            .trial = std::bind_front(drag_beads, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = [plan](std::vector<measure::Estimate>& estimates) { return conclude(plan, estimates); }};
}

Rows<DragPlan> DragPlan::rows() {
    using Plan = DragPlan;
    return Rows<DragPlan>{
        {"torques", &Plan::torques,
         "of the orienting field, ascending; for P from below a half to nearly one.  One < 0 may come first: "
         "it acts last and turns the rods round, so that P passes through 0",
         "mg mm^2/s^2"},
        {"warm_up", &Plan::warm_up, "once, in the strongest field; less than m rho/Gamma", "s", not_negative},
        {"time", &Plan::time, "in each field; together several times m rho/Gamma and 1/a", "s", positive},
        {"windows", &Plan::windows, "of equal length in that time", "", within(1, 1000)},
        {"frame", &Plan::frame, "between samples of P", "s", positive},
        {"bend", &Plan::bend,
         "fit a term in |P|^2 P besides the one in P, which makes the error of the slope four times larger; "
         "false: fit a straight line, and the remark reports whether the data follow one"},
    };
}

}  // namespace drover::calibrate
