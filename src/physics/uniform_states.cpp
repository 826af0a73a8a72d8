// physics/uniform_states.cpp: roots of the uniform equations, by GSL, and effective coefficients.
#include "drover/physics/uniform_states.hpp"

#include <gsl/gsl_poly.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "drover/physics/equations.hpp"

namespace drover::physics {

namespace {
/// The coefficients at some densities; zero for what the form has no field for.
struct Values {
    Dependence a, b, drag, driving, weathercock;
};

Values values_at(const Equations& e, double beads, double rods) {
    for (const auto& [key, coefficient] : named(e))
        require(std::isfinite(coefficient->at(beads, rods).value), {},
                "{} has no value at the densities {} (beads) and {} (rods), beyond its table of {}; expected densities "
                "inside, or table.outside = \"hold\"",
                key, beads, rods, coefficient->table() ? coefficient->table()->range_text() : "");
    return {.a = e.relaxation.at(beads, rods),
            .b = e.saturation.at(beads, rods),
            .drag = e.drag.at(beads, rods),
            .driving = e.driving.at(beads, rods),
            .weathercock = e.weathercock.at(beads, rods)};
}

Eigen::Vector2d outer_force(const Equations& e) {
    if (has_term(e, "force") && e.model.force.kind == "uniform") return {e.model.force.x, e.model.force.y};
    return Eigen::Vector2d::Zero();
}

/// Real roots of b P^3 + a P = h, h >= 0, each once, largest first, polished to rounding.
std::vector<double> orders(double b, double a, double h) {
    std::vector<double> roots;
    if (b == 0.0) {
        if (a != 0.0) roots.push_back(h / a);
        return roots;
    }
    std::array<double, 3> found{};
    const int count = gsl_poly_solve_cubic(0.0, a / b, -h / b, &found[0], &found[1], &found[2]);
    for (int i = count; i-- > 0;) {
        double p = found[static_cast<std::size_t>(i)];
        for (int step = 0; step < 3; ++step) {
            const double slope = 3.0 * b * p * p + a;
            if (slope != 0.0) p -= (b * p * p * p + a * p - h) / slope;
        }
        if (roots.empty() || p != roots.back()) roots.push_back(p);
    }
    return roots;
}

UniformPoint at_rest(double beads, double rods) { return {.bead_density = beads, .rod_density = rods}; }

/// States with the order along a field (its size may be zero), v = (alpha p + f)/Gamma for each.
StationaryStates with_field(const Eigen::Vector2d& field, double b, double a, const UniformPoint& rest,
                            const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& velocity) {
    StationaryStates result;
    const auto add = [&](const char* name, const Eigen::Vector2d& order, bool free) {
        result.states.push_back({.name = name, .point = rest, .free_direction = free});
        result.states.back().point.order = order;
        result.states.back().point.velocity = velocity(order);
    };
    const double size = field.norm();
    if (size > 0.0) {
        const std::vector<double> found = orders(b, a, size);
        for (const double p : found) {
            // Of two on one side the one with less order has a name of its own.
            const bool less = std::any_of(found.begin(), found.end(), [&](double other) {
                return (other > 0.0) == (p > 0.0) && std::abs(other) > std::abs(p);
            });
            add(p > 0.0 ? (less ? "weakly along the field" : "along the field")
                        : (less ? "weakly against the field" : "against the field"),
                p * field / size, false);
        }
        if (result.states.empty())
            result.no_order = "nothing holds the order against the field: a - lambda alpha/Gamma and b are 0";
        return result;
    }
    add("isotropic", Eigen::Vector2d::Zero(), false);
    if (a * b < 0.0) add("ordered", Eigen::Vector2d(std::sqrt(-a / b), 0.0), true);
    else if (b == 0.0 && a < 0.0)
        result.no_order =
            text("a - lambda alpha/Gamma = {:.6g} /s < 0, but relaxation.saturation is 0: order grows without bound",
                 a);
    else if (b < 0.0) result.no_order = text("relaxation.saturation is {:.6g} < 0: order grows without bound", b);
    else if (a == 0.0 && b == 0.0) result.no_order = "a - lambda alpha/Gamma and b are 0: every order stays as it is";
    else result.no_order = text("a - lambda alpha/Gamma = {:.6g} /s is not below 0", a);
    return result;
}

/// Beads that nothing holds back are at rest relative to nothing: a steady state needs the other forces on them to vanish.
StationaryStates without_drag(const Equations& e, const Values& c, const UniformPoint& rest) {
    const Eigen::Vector2d force = outer_force(e), field(e.model.orienting_field.x, e.model.orienting_field.y);
    const double alpha = c.driving.value, lambda = c.weathercock.value;
    if (alpha == 0.0) {
        if (force.norm() == 0.0)
            return with_field(field, c.b.value, c.a.value, rest,
                              [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); });
        return {.states = {},
                .no_order = "drag.coefficient is 0 and a force acts on the beads: they gain speed for ever"};
    }
    const Eigen::Vector2d order = -force / alpha;
    const Eigen::Vector2d turning = (c.a.value + c.b.value * order.squaredNorm()) * order - field;  // lambda v
    if (lambda == 0.0 && turning.norm() > 0.0)
        return {.states = {},
                .no_order =
                    "drag.coefficient is 0: driven beads gain speed for ever, and weathercock.strength = 0 lets none "
                    "of it back"};
    StationaryStates result;
    result.states.push_back({.name = order.norm() == 0.0 ? "isotropic" : "ordered", .point = rest});
    result.states.back().point.order = order;
    if (lambda != 0.0) result.states.back().point.velocity = turning / lambda;
    if (order.norm() == 0.0) result.no_order = "drag.coefficient is 0: beads driven by order gain speed for ever";
    return result;
}
}  // namespace

double direction_of(const UniformPoint& point) {
    const Eigen::Vector2d& v = point.order.norm() > 0.0 ? point.order : point.velocity;
    return v.norm() > 0.0 ? std::atan2(v.y(), v.x()) : 0.0;
}

bool is_mirrored(const UniformPoint& point) {
    const Eigen::Vector2d &p = point.order, &v = point.velocity;
    return std::abs(p.x() * v.y() - p.y() * v.x()) <= 1e-12 * p.norm() * v.norm();
}

StationaryStates stationary_states(const Equations& e, double bead_density, double rod_density) {
    const Values c = values_at(e, bead_density, rod_density);
    const UniformPoint rest = at_rest(bead_density, rod_density);
    const Eigen::Vector2d field(e.model.orienting_field.x, e.model.orienting_field.y);
    if (e.form.velocity == Velocity::absent)
        return with_field(field, c.b.value, c.a.value, rest,
                          [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); });
    const double drag = c.drag.value, alpha = c.driving.value;
    if (drag == 0.0) return without_drag(e, c, rest);
    const Eigen::Vector2d force = outer_force(e);
    return with_field(field + c.weathercock.value / drag * force, c.b.value,
                      c.a.value - c.weathercock.value * alpha / drag, rest,
                      [=](const Eigen::Vector2d& order) -> Eigen::Vector2d { return (alpha * order + force) / drag; });
}

EffectiveCoefficients effective_coefficients(const Equations& e, double bead_density, double rod_density) {
    const Values c = values_at(e, bead_density, rod_density);
    const Model& m = e.model;
    const Elasticity& k = m.elasticity;
    EffectiveCoefficients r{.relaxation = c.a.value,
                            .relaxation_by_beads = c.a.by_beads,
                            .relaxation_by_rods = c.a.by_rods,
                            .pressure_beads = m.pressure.beads,
                            .pressure_rods = m.pressure.rods,
                            .stiffness_across = k.stiffness,
                            .stiffness_along = k.stiffness + k.splay};
    // eta and Gamma of the order across q: (Gamma + eta q^2)(a + K3 q^2) = lambda alpha where it neither grows nor decays.
    double drag = 1.0, shear = 0.0, product = 0.0, beads_carried = 0.0;
    if (e.form.velocity != Velocity::absent) {
        drag = c.drag.value;
        shear = m.viscosity.shear;
        product = c.weathercock.value * c.driving.value;
        const auto over_drag = [&](double value) {
            return value == 0.0 ? 0.0 : value / drag;
        };  // nothing is carried: no drag asked
        const double gain = over_drag(product);
        const double moved = e.form.velocity == Velocity::dynamic ? m.inertia.bead_mass * bead_density : 0.0;
        r.inertia = 1.0 + over_drag(moved * gain);
        r.relaxation -= gain;
        const auto slope = [&](double lambda, double alpha, double gamma) {
            return over_drag(lambda * c.driving.value + c.weathercock.value * alpha - gain * gamma);
        };
        r.relaxation_by_beads -= slope(c.weathercock.by_beads, c.driving.by_beads, c.drag.by_beads);
        r.relaxation_by_rods -= slope(c.weathercock.by_rods, c.driving.by_rods, c.drag.by_rods);
        if (e.form.bead_density >= 0) beads_carried = over_drag(bead_density * c.driving.value);
        r.pressure_beads += over_drag(c.weathercock.value * m.stiffness.beads);
        r.pressure_rods += over_drag(c.weathercock.value * m.stiffness.rods);
        r.stiffness_across += over_drag(gain * m.viscosity.shear);
        r.stiffness_along += over_drag(gain * (m.viscosity.shear + m.viscosity.bulk));
    }
    const double rods_carried =
        e.form.rod_density < 0 ? 0.0 : m.current.speed * (e.form.order_is_density ? 1.0 : rod_density);
    r.sound_stiffness = rods_carried * r.pressure_rods + beads_carried * r.pressure_beads;
    // eta K3 Q^2 + (Gamma K3 + eta a) Q + Gamma abar = 0 for Q = q^2: the form of the root that survives eta = 0.  Order that beads do
    // not turn knows nothing of their flow.
    const double middle = drag * k.stiffness + shear * c.a.value;
    const double under = middle * middle - 4.0 * shear * k.stiffness * drag * r.relaxation;
    const double square =
        product == 0.0 ? -c.a.value / k.stiffness : -2.0 * drag * r.relaxation / (middle + std::sqrt(under));
    if (square < 0.0) r.correlation_length = 1.0 / std::sqrt(-square);
    else if (square == 0.0) r.correlation_length = std::numeric_limits<double>::infinity();
    else if (r.relaxation < 0.0) r.neutral_wavenumber = std::sqrt(square);
    return r;
}

}  // namespace drover::physics
