// physics/uniform_states.cpp: roots of the uniform equations, by GSL, and effective coefficients.
#include "drover/physics/uniform_states.hpp"

#include <gsl/gsl_poly.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drover/model/theory.hpp"

namespace drover::physics {

namespace {
/// The coefficients at some densities; zero for what the form has no field for.
struct Values {
    Dependence a, b, drag, driving, weathercock;
};

Values values_at(const Equations& e, double beads, double rods) {
    require_values(e, beads, rods);
    return {.a = e.relaxation.at(beads, rods),
            .b = e.saturation.at(beads, rods),
            .drag = e.drag.at(beads, rods),
            .driving = e.driving.at(beads, rods),
            .weathercock = e.weathercock.at(beads, rods)};
}

/// The uniform sources of the equation of a vector.
Eigen::Vector2d uniform_source(const Equations& e, int field) {
    if (field == FieldIndex::bead_velocity_x && e.model.force.kind == "uniform")
        return {e.model.force.x, e.model.force.y};
    if (field == FieldIndex::polar_order_x) return {e.model.orienting_field.x, e.model.orienting_field.y};
    return Eigen::Vector2d::Zero();
}

/// Whether the uniform states are those of the built-in equations: what the scene adds vanishes in them.
bool has_closed_states(const Equations& e) {
    for (std::size_t n = 0; n < e.terms().size(); ++n)
        if (e.terms()[n].starts_with("terms[") && !e.forces().terms()[n].vanishes_when_uniform) return false;
    return true;
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

/// States with the order along a field (its size may be zero), v = [(alpha + alpha_3 |p|^2) p + f]/Gamma for each; `b`
/// is the whole saturation.
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
        if (result.states.empty()) result.no_order = "no term balances the field: a - lambda alpha/Gamma and b are 0";
        return result;
    }
    add("isotropic", Eigen::Vector2d::Zero(), false);
    if (a * b < 0.0) add("ordered", Eigen::Vector2d(std::sqrt(-a / b), 0.0), true);
    else if (b == 0.0 && a < 0.0)
        result.no_order =
            text("a - lambda alpha/Gamma = {:.6g} /s < 0, but relaxation.saturation is 0: order grows without bound",
                 a);
    else if (b < 0.0) result.no_order = text("b - lambda alpha_3/Gamma is {:.6g} < 0: order grows without bound", b);
    else if (a == 0.0 && b == 0.0)
        result.no_order = "a - lambda alpha/Gamma and b are 0: every value of the order is stationary";
    else result.no_order = text("a - lambda alpha/Gamma = {:.6g} /s is not below 0", a);
    return result;
}

/// Without drag a steady state requires that the other forces on the beads vanish.
StationaryStates without_drag(const Equations& e, const Values& c, const UniformPoint& rest) {
    const Eigen::Vector2d force = uniform_source(e, FieldIndex::bead_velocity_x),
                          field = uniform_source(e, FieldIndex::polar_order_x);
    const double alpha = c.driving.value, lambda = c.weathercock.value;
    if (alpha == 0.0) {
        if (force.norm() == 0.0)
            return with_field(field, c.b.value, c.a.value, rest,
                              [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); });
        return {.states = {},
                .no_order = "drag.coefficient is 0 and a force acts on the beads: they accelerate without limit"};
    }
    const Eigen::Vector2d order = -force / alpha;
    const Eigen::Vector2d turning = (c.a.value + c.b.value * order.squaredNorm()) * order - field;  // lambda v
    if (lambda == 0.0 && turning.norm() > 0.0)
        return {.states = {},
                .no_order =
                    "drag.coefficient is 0 and weathercock.strength is 0: driven beads accelerate without limit"};
    StationaryStates result;
    result.states.push_back({.name = order.norm() == 0.0 ? "isotropic" : "ordered", .point = rest});
    result.states.back().point.order = order;
    if (lambda != 0.0) result.states.back().point.velocity = turning / lambda;
    if (order.norm() == 0.0) result.no_order = "drag.coefficient is 0: driven beads accelerate without limit";
    return result;
}
}  // namespace

bool is_mirrored(const UniformPoint& point) {
    const Eigen::Vector2d &p = point.order, &v = point.velocity;
    return std::abs(p.x() * v.y() - p.y() * v.x()) <= 1e-12 * p.norm() * v.norm();
}

namespace {
/// Uniform states of arbitrary terms, by Newton's method from many starting points; it may miss a state.
StationaryStates searched_states(const Equations& e, const UniformPoint& rest, double scale) {
    static_cast<void>(e.linearised(rest));  // throws where linear theory does not exist
    const model::Equations equations = e.solver(reference(e.model.uniform));
    const auto place = [&](int field) { return static_cast<std::size_t>(e.component(field)); };
    const std::size_t p = place(FieldIndex::polar_order_x);
    model::UniformState means = equations.reference();
    if (e.form.bead_density >= 0) means[place(FieldIndex::bead_density)] = rest.bead_density;
    if (e.form.rod_density >= 0) means[place(FieldIndex::rod_density)] = rest.rod_density;
    const bool free = model::turns_freely(equations);
    const int directions = free ? 1 : 16;
    std::vector<model::UniformState> guesses;
    for (const double size : {0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0})
        for (int n = 0; n < directions; ++n) {
            const double angle = 2.0 * std::numbers::pi * n / directions + (free ? 0.0 : 0.03);
            guesses.push_back(means);
            guesses.back()[p] = size * scale * std::cos(angle);
            guesses.back()[p + 1] = size * scale * std::sin(angle);
        }
    StationaryStates result{.states = {},
                            .no_order = "no ordered state was found by Newton's method from 7 sizes of the order"};
    for (const model::StationaryState& found : model::stationary_states_near(equations, means, guesses).states) {
        StationaryState state{.name = "isotropic", .point = rest, .free_direction = found.has_free_direction};
        Eigen::Vector2d &order = state.point.order, &velocity = state.point.velocity;
        order = {found.values[p], found.values[p + 1]};
        if (e.form.velocity != Velocity::absent) {
            const std::size_t v = place(FieldIndex::bead_velocity_x);
            velocity = {found.values[v], found.values[v + 1]};
        }
        if (!(order.norm() < 1e4 * scale)) continue;
        if (free && order.x() < 0.0) order *= -1.0, velocity *= -1.0;  // the flow is along x
        if (!found.is_isotropic) {
            result.no_order.clear();
            state.name =
                free ? "ordered"
                     : text("ordered at {:.4g} degrees", 180.0 / std::numbers::pi * std::atan2(order.y(), order.x()));
        }
        result.states.push_back(state);
    }
    std::stable_sort(result.states.begin(), result.states.end(),
                     [](const StationaryState& a, const StationaryState& b) {
                         return a.point.order.norm() < b.point.order.norm();
                     });
    return result;
}

/// A size of the order to search about.
double order_scale(const Equations& e, const UniformPoint& rest) {
    const double b = e.saturation.at(rest.bead_density, rest.rod_density).value,
                 a = e.relaxation.at(rest.bead_density, rest.rod_density).value;
    if (b > 0.0 && a != 0.0) return std::sqrt(std::abs(a / b));
    return e.form.order_is_density ? rest.rod_density : 1.0;
}
}  // namespace

StationaryStates stationary_states(const Equations& e, double bead_density, double rod_density) {
    const Values c = values_at(e, bead_density, rod_density);
    const UniformPoint rest = at_rest({.bead_density = bead_density, .rod_density = rod_density});
    if (!has_closed_states(e)) return searched_states(e, rest, order_scale(e, rest));
    const Eigen::Vector2d field = uniform_source(e, FieldIndex::polar_order_x);
    if (e.form.velocity == Velocity::absent)
        return with_field(field, c.b.value, c.a.value, rest,
                          [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); });
    const double drag = c.drag.value, alpha = c.driving.value;
    const double cubic = e.model.driving.cubic;
    if (drag == 0.0) return cubic == 0.0 ? without_drag(e, c, rest) : searched_states(e, rest, order_scale(e, rest));
    const Eigen::Vector2d force = uniform_source(e, FieldIndex::bead_velocity_x);
    const double gain = c.weathercock.value / drag;
    return with_field(field + gain * force, c.b.value - gain * cubic, c.a.value - gain * alpha, rest,
                      [=](const Eigen::Vector2d& order) -> Eigen::Vector2d {
                          return ((alpha + cubic * order.squaredNorm()) * order + force) / drag;
                      });
}

namespace {
/// The linearisation about a uniform state, by fields.
struct Linear {
    Linear(const Equations& e, const UniformPoint& about) : equations(e), at(e.linearised(about)) {}
    /// The coefficient of (i q_x)^x (i q_y)^y of one field in the equation of another; 0 where one is absent.
    double factor(int x, int y, int row, int column) const {
        const int i = equations.component(row), k = equations.component(column);
        for (const model::LinearisedAt::Power& power : at->powers())
            if (power.x == x && power.y == y && i >= 0 && k >= 0) return power.factors(i, k);
        return 0.0;
    }
    double constant(int row, int column) const { return factor(0, 0, row, column); }
    double by_gradient(int row, int column) const { return factor(1, 0, row, column); }  ///< along x
    double by_curvature(int row, int column) const { return factor(2, 0, row, column); }

    const Equations& equations;
    std::shared_ptr<const model::LinearisedAt> at;
};

/// Coefficients of small v and p about a state at rest, with their slopes in the densities, whatever terms they come
/// from.
Values effective_values(const Equations& e, const Linear& at, const UniformPoint& rest) {
    constexpr int rho = FieldIndex::bead_density, sigma = FieldIndex::rod_density, v = FieldIndex::bead_velocity_x,
                  p = FieldIndex::polar_order_x;
    // In the columns of the densities the linearisation about a small v or p is a slope times it: a power of two, whose
    // square is below rounding.
    constexpr double small = 0x1p-30;
    UniformPoint moving = rest, ordered = rest;
    moving.velocity.x() = ordered.order.x() = small;
    const Linear by_velocity(e, moving), by_order(e, ordered);
    const auto values = [&](int row, int column, const Linear& slopes, double sign) {
        return Dependence{.value = sign * at.constant(row, column),
                          .by_beads = sign * slopes.constant(row, rho) / small,
                          .by_rods = sign * slopes.constant(row, sigma) / small};
    };
    return {.a = values(p, p, by_order, -1.0),
            .b = {},
            .drag = values(v, v, by_velocity, -1.0),
            .driving = values(v, p, by_order, 1.0),
            .weathercock = values(p, v, by_velocity, 1.0)};
}
}  // namespace

double effective_relaxation(const Equations& e, double bead_density, double rod_density) {
    require_values(e, bead_density, rod_density);
    const UniformPoint rest = at_rest({.bead_density = bead_density, .rod_density = rod_density});
    constexpr int v = FieldIndex::bead_velocity_x, p = FieldIndex::polar_order_x;
    const Linear at(e, rest);
    const double a = -at.constant(p, p), product = at.constant(p, v) * at.constant(v, p);
    return product == 0.0 ? a : a - product / -at.constant(v, v);
}

EffectiveCoefficients effective_coefficients(const Equations& e, double bead_density, double rod_density) {
    require_values(e, bead_density, rod_density);
    const UniformPoint rest = at_rest({.bead_density = bead_density, .rod_density = rod_density});
    const Linear at(e, rest);
    const Values c = effective_values(e, at, rest);
    constexpr int rho = FieldIndex::bead_density, sigma = FieldIndex::rod_density, v_x = FieldIndex::bead_velocity_x,
                  v_y = FieldIndex::bead_velocity_y, p_x = FieldIndex::polar_order_x, p_y = FieldIndex::polar_order_y;
    const double stiffness = at.by_curvature(p_y, p_y);  // K3
    EffectiveCoefficients r{.relaxation = c.a.value,
                            .relaxation_by_beads = c.a.by_beads,
                            .relaxation_by_rods = c.a.by_rods,
                            .pressure_beads = 0.0 - at.by_gradient(p_x, rho),
                            .pressure_rods = 0.0 - at.by_gradient(p_x, sigma),
                            .stiffness_across = stiffness,
                            .stiffness_along = at.by_curvature(p_x, p_x)};
    // eta and Gamma of the order across q: (Gamma + eta q^2)(a + K3 q^2) = lambda alpha where it neither grows nor
    // decays.
    double drag = 1.0, shear = 0.0, product = 0.0, beads_carried = 0.0;
    if (e.form.velocity != Velocity::absent) {
        drag = c.drag.value;
        shear = at.by_curvature(v_y, v_y);
        product = c.weathercock.value * c.driving.value;
        const auto over_drag = [&](double value) {
            return value == 0.0 ? 0.0 : value / drag;  // no coupling to the flow: no drag is needed
        };
        const double gain = over_drag(product);
        const double moved = e.form.velocity == Velocity::dynamic ? e.model.inertia.bead_mass * bead_density : 0.0;
        r.inertia = 1.0 + over_drag(moved * gain);
        r.relaxation -= gain;
        const auto slope = [&](double lambda, double alpha, double gamma) {
            return over_drag(lambda * c.driving.value + c.weathercock.value * alpha - gain * gamma);
        };
        r.relaxation_by_beads -= slope(c.weathercock.by_beads, c.driving.by_beads, c.drag.by_beads);
        r.relaxation_by_rods -= slope(c.weathercock.by_rods, c.driving.by_rods, c.drag.by_rods);
        if (e.form.bead_density >= 0) beads_carried = over_drag(bead_density * c.driving.value);
        r.pressure_beads += over_drag(c.weathercock.value * (0.0 - at.by_gradient(v_x, rho)));
        r.pressure_rods += over_drag(c.weathercock.value * (0.0 - at.by_gradient(v_x, sigma)));
        r.stiffness_across += over_drag(gain * shear);
        r.stiffness_along += over_drag(gain * at.by_curvature(v_x, v_x));
    }
    const double rods_carried = e.form.rod_density < 0 ? 0.0 : 0.0 - at.by_gradient(sigma, p_x);
    r.sound_stiffness = rods_carried * r.pressure_rods + beads_carried * r.pressure_beads;
    // eta K3 Q^2 + (Gamma K3 + eta a) Q + Gamma abar = 0 for Q = q^2: the form of the root that survives eta = 0.
    // Order that beads do not turn is independent of their flow.
    const double middle = drag * stiffness + shear * c.a.value;
    const double under = middle * middle - 4.0 * shear * stiffness * drag * r.relaxation;
    const double square =
        product == 0.0 ? -c.a.value / stiffness : -2.0 * drag * r.relaxation / (middle + std::sqrt(under));
    if (square < 0.0) r.correlation_length = 1.0 / std::sqrt(-square);
    else if (square == 0.0) r.correlation_length = std::numeric_limits<double>::infinity();
    else if (r.relaxation < 0.0) r.neutral_wavenumber = std::sqrt(square);
    return r;
}

}  // namespace drover::physics
