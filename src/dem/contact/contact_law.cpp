// dem/contact/contact_law.cpp: the choice of the contact law, the time step that a soft law needs, and the impulse of
// one contact with friction along the slip before it.
#include "dem/contact/contact_law.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "dem/impact/impact_increment.hpp"

namespace drover::dem {

namespace {
constexpr double min_steps = 20.0;  // of dt within the shortest contact

/// Smallest reduced mass of a contact of two bodies [mg].
double min_reduced_mass(const std::vector<Shape>& shapes) {
    double response = 0.0;  // largest change of the normal velocity at a contact of a body per normal impulse [1/mg]
    for (const Shape& shape : shapes)
        for (const double at : shape.at)
            response = std::max(response, 1.0 / shape.mass + at * at / shape.inertia_across);
    return 0.5 / response;
}

void check_restitution(const Setup& setup, const Locate& locate) {
    for (const auto& [name, value] : values_of(setup.restitution)) {
        const std::string key = "restitution." + name;
        require(std::get<double>(value) > 0.0, locate(key),
                "{} = 0 with contacts.model = \"{}\": such a contact never ends; expected a value above 0, or "
                "contacts.model = \"impulse\"",
                key, setup.contacts.model);
    }
}

/// The slip before a contact and the response along it.
struct SlipLine {
    double speed = 0.0, x = 0.0, y = 0.0;  ///< |u_t| and its direction t
    double across = 0.0, along = 0.0;      ///< n.K t and t.K t
};
SlipLine slip_line(const Response& w, const Slip& slip) {
    const double speed = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    if (speed == 0.0) return {};
    const double x = slip.x / speed, y = slip.y / speed;
    return {.speed = speed,
            .x = x,
            .y = y,
            .across = w.nx * x + w.ny * y,
            .along = w.xx * x * x + 2.0 * w.xy * x * y + w.yy * y * y};
}

/// The largest friction coefficient m for which sliding creates no energy.  J = J_n (n - m t) changes it by
/// -J_n/(2 D) q(m), D = n.K(n - m t) > 0, q(m) = (1 - e)|u_n| K_nn + 2 m (|u_t| K_nn + e |u_n| K_nt)
/// - m^2 (2 |u_t| K_nt + (1 + e) |u_n| K_tt).  q is negative where D is 0, so D > 0 up to this m.
double max_sliding_friction(const Response& w, double restitution, double approach, const SlipLine& line) {
    const double constant = (1.0 - restitution) * approach * w.nn;
    const double linear = line.speed * w.nn + restitution * approach * line.across;
    const double square = 2.0 * line.speed * line.across + (1.0 + restitution) * approach * line.along;
    const double discriminant = linear * linear + constant * square;
    if (linear >= 0.0) return square > 0.0 ? (linear + std::sqrt(discriminant)) / square : infinite;
    return discriminant >= 0.0 ? constant / (std::sqrt(discriminant) - linear) : infinite;
}

/// Twice the work of an impulse: J.(u + u').
double twice_work(const Response& w, const Slip& slip, double n, double x, double y) {
    return n * (2.0 * slip.n + w.nn * n + 2.0 * (w.nx * x + w.ny * y)) +
           x * (2.0 * slip.x + w.xx * x + 2.0 * w.xy * y) + y * (2.0 * slip.y + w.yy * y);
}
}  // namespace

ImpactLaw ImpactLaw::from(const ContactControl& control) {
    return {.group = control.law,
            .restitution = control.restitution,
            .track_slip = control.track_slip,
            .increments = control.increments,
            .inelastic_threshold = control.inelastic_threshold};
}

PairwiseLaw PairwiseLaw::from(const ContactControl& control) {
    return {.friction = control.friction == PairwiseFriction::decoupled ? decoupled : stop_or_slide,
            .order = control.order,
            .rod_step = control.rod_step};
}

ContactLaw contact_law(const ContactControl& control) {
    switch (control.model) {
        case ContactModel::spring_dashpot: return SpringDashpot(control);
        case ContactModel::repulsive_spring: return RepulsiveSpring(control);
        case ContactModel::impulse: break;
    }
    if (PairwiseLaw::is_chosen(control)) return PairwiseLaw::from(control);
    return ImpactLaw::from(control);
}

void check_contact_law(const Setup& setup, const std::vector<Shape>& shapes, double dt, const Locate& locate) {
    require(dt > 0.0 && std::isfinite(dt), locate("time.dt"), "time.dt = {} s; expected a finite number > 0", dt);
    const auto check = [&]<class Law>(const Law& law) {
        if constexpr (std::is_same_v<Law, PairwiseLaw>) {
            constexpr double periods = 0.05;
            require(
                dt * setup.plates.frequency <= periods, locate("time.dt"),
                "time.dt = {} s with plates.frequency = {} 1/s and contacts.law = \"pairwise\"; expected at most {} "
                "of a period: otherwise beads penetrate the plates",
                dt, setup.plates.frequency, periods);
        }
        if constexpr (SoftLaw<Law>) {
            check_restitution(setup, locate);
            if (shapes.empty()) return;
            constexpr double below = 0.995;  // the limit, when it is printed with three digits
            const double shortest = law.contact_time(min_reduced_mass(shapes)), steps = shortest / dt;
            require(steps >= min_steps * (1.0 - 1e-9), locate("time.dt"),
                    "time.dt = {} s is {:.3g} steps of the shortest contact, {:.3g} s; expected at least {} with "
                    "contacts.model = \"{}\": choose time.dt <= {:.3g}, or softer contacts",
                    dt, steps, shortest, min_steps, setup.contacts.model, below * shortest / min_steps);
        }
    };
    std::visit(check, contact_law(setup.contacts));
    // The motion of the plates within a step is a series in dt times the frequency.
    constexpr double min_steps_of_period = 20.0;
    const Plates& plates = setup.plates;
    const double steps = 1.0 / (dt * plates.frequency);
    require(plates.amplitude == 0.0 || steps >= min_steps_of_period, locate("time.dt"),
            "time.dt = {} s is {:.3g} steps a period of plates.frequency = {} 1/s; expected at least {}: choose a "
            "smaller time.dt",
            dt, steps, plates.frequency, min_steps_of_period);
}

PairwiseImpulse stop_or_slide(const Response& w, double restitution, double friction, const Slip& slip) {
    const double change = -(1.0 + restitution) * slip.n;
    if (friction == 0.0 || w.ixx == 0.0) return {.n = change / w.nn};
    // J_t = -(a + b J_n): a stops the slip, b balances that of the normal impulse.
    const double ax = w.ixx * slip.x + w.ixy * slip.y, ay = w.ixy * slip.x + w.iyy * slip.y;
    const double bx = w.ixx * w.nx + w.ixy * w.ny, by = w.ixy * w.nx + w.iyy * w.ny;
    const double n = (change + w.nx * ax + w.ny * ay) / (w.nn - w.nx * bx - w.ny * by);
    const double x = -(ax + bx * n), y = -(ay + by * n);
    const bool holds = n > 0.0 && x * x + y * y <= friction * friction * n * n;
    const bool gains = holds && twice_work(w, slip, n, x, y) > 0.0;
    if (holds && !gains) return {.n = n, .x = x, .y = y};
    const SlipLine line = slip_line(w, slip);
    if (line.speed == 0.0) return {.n = change / w.nn, .limited = gains};
    const double max_friction = max_sliding_friction(w, restitution, -slip.n, line),
                 m = std::min(friction, max_friction);
    const double sliding = change / (w.nn - m * line.across);
    return {.n = sliding,
            .x = -m * sliding * line.x,
            .y = -m * sliding * line.y,
            .limited = gains || max_friction < friction};
}

PairwiseImpulse decoupled(const Response& w, double restitution, double friction, const Slip& slip) {
    const double n = -(1.0 + restitution) * slip.n / w.nn;
    const SlipLine line = w.ixx > 0.0 ? slip_line(w, slip) : SlipLine{};
    if (friction == 0.0 || line.speed == 0.0) return {.n = n};
    // J_t changes the energy by J_t^2 K_tt/2 - J_t (|u_t| + J_n K_nt) beside the loss of J_n along the normal.
    const double wanted = std::min(friction * n, line.speed / line.along);
    const double linear = line.speed + n * line.across, loss = -(1.0 - restitution) * slip.n * n;
    const double root = std::sqrt(linear * linear + line.along * loss);
    const double max_impulse =
        linear > 0.0 ? (linear + root) / line.along : (root > 0.0 ? loss / (root - linear) : 0.0);
    const double t = std::min(wanted, max_impulse);
    return {.n = n, .x = -t * line.x, .y = -t * line.y, .limited = max_impulse < wanted};
}

}  // namespace drover::dem
