// calibrate/slow_order.cpp: effective coefficients from the linearisation about the isotropic state; the variance of
// the order of independent rods, a sum over kept waves.
#include "calibrate/slow_order.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "drover/base/error.hpp"
#include "drover/model/linearised_at.hpp"
#include "physics/compiled_model.hpp"
#include "physics/program_functions.hpp"

namespace drover::calibrate {

namespace {
/// The right sides alone, of fields with a mass and of fields in balance as well.
model::Equations right_sides(const physics::Equations& equations) {
    model::Model alone = equations.solver().model();
    for (model::Field& field : alone.fields) {
        if (field.left == model::LeftSide::balance) field.left = model::LeftSide::rate;
        field.mass = {};
        field.noise = 0.0;
    }
    return model::Equations(alone);
}

/// The right sides linearised about states near the isotropic one.
class RightSides {
public:
    explicit RightSides(const physics::Equations& equations)
        : equations_(right_sides(equations)), rest_(equations_.reference()) {
        for (const auto& [field, first] : model::placed_fields(equations_.model()))
            for (const auto& [symbol, place] : {std::pair{"rho", &rho}, {"sigma", &sigma}, {"v", &v}, {"p", &p}})
                if (field.symbol == symbol) *place = static_cast<int>(first);
    }

    /// About the state at rest, but for one component.
    model::LinearisedAt about(int component = -1, double value = 0.0) const {
        model::UniformState state = rest_;
        if (component >= 0) state[static_cast<std::size_t>(component)] = value;
        return {equations_, state};
    }

    int rho = -1, sigma = -1, v = -1, p = -1;  ///< places of the fields; -1: not a field

private:
    model::Equations equations_;
    model::UniformState rest_;
};

/// The factor of (i q_x)^x (i q_y)^y of one component in the right side of another; 0 where one is absent.
double factor(const model::LinearisedAt& at, int x, int y, int row, int column) {
    for (const model::LinearisedAt::Power& power : at.powers())
        if (power.x == x && power.y == y && row >= 0 && column >= 0) return power.factors(row, column);
    return 0.0;
}

/// A value, and its slopes in the densities of beads and rods.
struct Dependence {
    double value = 0.0, by_beads = 0.0, by_rods = 0.0;
};

/// Coefficients of small v and p about the state at rest, with their slopes in the densities, whatever terms they come
/// from.
struct SlowValues {
    Dependence a, drag, driving, weathercock;
};

SlowValues values_at(const RightSides& of, const model::LinearisedAt& at) {
    // In the columns of the densities the linearisation about a small v or p is a slope times it: a power of two, whose
    // square is below rounding.
    constexpr double small = 0x1p-30;
    const model::LinearisedAt by_velocity = of.about(of.v, small), by_order = of.about(of.p, small);
    const auto values = [&](int row, int column, const model::LinearisedAt& slopes, double sign) {
        return Dependence{.value = sign * factor(at, 0, 0, row, column),
                          .by_beads = sign * factor(slopes, 0, 0, row, of.rho) / small,
                          .by_rods = sign * factor(slopes, 0, 0, row, of.sigma) / small};
    };
    return {.a = values(of.p, of.p, by_order, -1.0),
            .drag = values(of.v, of.v, by_velocity, -1.0),
            .driving = values(of.v, of.p, by_order, 1.0),
            .weathercock = values(of.p, of.v, by_velocity, 1.0)};
}

/// The mass that moves with the beads per area; 0 where they have no inertia.
double moved_mass(const physics::Equations& equations) {
    if (presence(equations.model, "v") != physics::Presence::rate) return 0.0;
    return number(equations.model, "inertia.bead_mass") * number(equations.model, "uniform.bead_density");
}

/// What the flow of the beads adds to the coefficients of the order; how much beads the order carries.
double add_flow(const physics::Equations& e, const RightSides& of, const model::LinearisedAt& at, const SlowValues& c,
                SlowOrder& r) {
    const double drag = c.drag.value;
    const auto over_drag = [&](double value) {
        return value == 0.0 ? 0.0 : value / drag;  // no coupling to the flow: no drag is needed
    };
    const double gain = over_drag(c.weathercock.value * c.driving.value);
    r.inertia = 1.0 + over_drag(moved_mass(e) * gain);
    r.relaxation -= gain;
    const auto slope = [&](double lambda, double alpha, double gamma) {
        return over_drag(lambda * c.driving.value + c.weathercock.value * alpha - gain * gamma);
    };
    r.relaxation_by_beads -= slope(c.weathercock.by_beads, c.driving.by_beads, c.drag.by_beads);
    r.relaxation_by_rods -= slope(c.weathercock.by_rods, c.driving.by_rods, c.drag.by_rods);
    r.pressure_beads += over_drag(c.weathercock.value * (0.0 - factor(at, 1, 0, of.v, of.rho)));
    r.pressure_rods += over_drag(c.weathercock.value * (0.0 - factor(at, 1, 0, of.v, of.sigma)));
    r.stiffness_across += over_drag(gain * factor(at, 2, 0, of.v + 1, of.v + 1));
    r.stiffness_along += over_drag(gain * factor(at, 2, 0, of.v, of.v));
    return of.rho < 0 ? 0.0 : over_drag(number(e.model, "uniform.bead_density") * c.driving.value);
}

constexpr const char *rate_key = "relaxation.rate", *saturation_key = "relaxation.saturation";

/// Rods that do not touch each other, at the mean densities.
class IndependentRods {
public:
    explicit IndependentRods(physics::ModelValues model)
        : compiled_(without_contact(model)), means_(mean_densities(model)) {}

    double at(const char* key) const { return compiled_.coefficient(key).at(means_); }

    /// Why their fluctuations do not saturate the order, if they do not.
    std::optional<std::string> why_none() const {
        for (const char* key : {rate_key, saturation_key, "noise.order"})
            if (!(at(key) > 0.0))
                return text(
                    "{} = {}; expected > 0: it is of rods that lose their direction, whose fluctuations "
                    "saturate the order",
                    key, at(key));
        if (compiled_.coefficient(rate_key).table() == nullptr) return {};
        return text("a table of {}; expected a number, or a polynomial in the densities", rate_key);
    }

    /// |p|^2 in the kept waves but q = 0.
    double variance(const numerics::KeptGrid& on) const {
        const double rate = at(rate_key), stiffness = at("elasticity.stiffness"), splay = at("elasticity.splay"),
                     bilaplacian = at("elasticity.bilaplacian");
        double sum = 0.0;
        numerics::for_kept_rows(on, [&](std::size_t first, std::size_t count) {
            const std::size_t row = first / numerics::columns(on.grid);
            for (std::size_t column = 0; column < count; ++column) {
                if (row == 0 && column == 0) continue;
                const numerics::Wavevector q = numerics::wavevector(on.grid, column, row);
                const double square = q.x * q.x + q.y * q.y;
                const double across = rate + stiffness * square + bilaplacian * square * square;
                sum += (column == 0 ? 1.0 : 2.0) * (1.0 / across + 1.0 / (across + splay * square));  // of k and -k
            }
        });
        return 0.5 * at("noise.order") / numerics::area(on.grid) * sum;
    }

private:
    static physics::ModelValues& without_contact(physics::ModelValues& model) {
        physics::number_in(model, "relaxation.contact") = 0.0;
        return model;
    }

    physics::CompiledModel compiled_;
    physics::Densities means_;
};
}  // namespace

SlowOrder slow_order(const physics::Equations& e) {
    require_values(e, mean_densities(e.model));
    const RightSides of(e);
    const model::LinearisedAt at = of.about();
    const SlowValues c = values_at(of, at);
    const int p_x = of.p, p_y = p_x + 1;
    const double stiffness = factor(at, 2, 0, p_y, p_y);  // K3
    SlowOrder r{.relaxation = c.a.value,
                .relaxation_by_beads = c.a.by_beads,
                .relaxation_by_rods = c.a.by_rods,
                .pressure_beads = 0.0 - factor(at, 1, 0, p_x, of.rho),
                .pressure_rods = 0.0 - factor(at, 1, 0, p_x, of.sigma),
                .stiffness_across = stiffness,
                .stiffness_along = factor(at, 2, 0, p_x, p_x)};
    // eta and Gamma of the order across q: (Gamma + eta q^2)(a + K3 q^2) = lambda alpha where it neither grows nor
    // decays.
    const bool flows = of.v >= 0;
    const double beads_carried = flows ? add_flow(e, of, at, c, r) : 0.0;
    const double rods_carried = of.sigma < 0 ? 0.0 : 0.0 - factor(at, 1, 0, of.sigma, p_x);
    r.sound_stiffness = rods_carried * r.pressure_rods + beads_carried * r.pressure_beads;
    // eta K3 Q^2 + (Gamma K3 + eta a) Q + Gamma abar = 0 for Q = q^2: the form of the root that survives eta = 0.
    // Order that beads do not turn is independent of their flow.
    const double drag = flows ? c.drag.value : 1.0, shear = flows ? factor(at, 2, 0, of.v + 1, of.v + 1) : 0.0;
    const double product = flows ? c.weathercock.value * c.driving.value : 0.0;
    const double middle = drag * stiffness + shear * c.a.value;
    const double under = middle * middle - 4.0 * shear * stiffness * drag * r.relaxation;
    const double square =
        product == 0.0 ? -c.a.value / stiffness : -2.0 * drag * r.relaxation / (middle + std::sqrt(under));
    if (square < 0.0) r.correlation_length = 1.0 / std::sqrt(-square);
    else if (square == 0.0) r.correlation_length = infinite;
    else if (r.relaxation < 0.0) r.neutral_wavenumber = std::sqrt(square);
    return r;
}

std::vector<ResultRow> slow_order_rows(const physics::Equations& equations, const SlowOrder& of) {
    const bool beads = has_fields(equations.model, {"rho"}), rods = has_fields(equations.model, {"sigma"}),
               velocity = has_fields(equations.model, {"v"});
    return {
        {"relaxation", "s-1",
         velocity ? "abar = a - c sigma - lambda alpha/Gamma; a flock forms where it is negative"
                  : "abar = a - c sigma; a flock forms where it is negative",
         of.relaxation},
        {"relaxation_by_beads", "mm2 s-1", "d abar/d rho", of.relaxation_by_beads, beads},
        {"relaxation_by_rods", "mm2 s-1", "d abar/d sigma", of.relaxation_by_rods, rods},
        {"inertia", "1", "chi = 1 + m rho lambda alpha/Gamma^2; divides the slow rates of the order", of.inertia,
         velocity},
        {"pressure_beads", "1", "Abar = A + lambda E/Gamma; rods turn away from high bead density where it is positive",
         of.pressure_beads, beads},
        {"pressure_rods", "1", "Bbar = B + lambda F/Gamma; rods turn away from high rod density where it is positive",
         of.pressure_rods, rods},
        {"stiffness_across", "mm2 s-1", "Kbar of the order transverse to q", of.stiffness_across},
        {"stiffness_along", "mm2 s-1", "Kbar of the order along q", of.stiffness_along},
        {"sound_stiffness", "mm2 s-2", "C0; sound transverse to p0 has the speed sqrt(C0/chi)", of.sound_stiffness,
         beads || rods},
        {"correlation_length", "mm", "xi of the order transverse to q in the isotropic state", of.correlation_length},
        {"neutral_wavenumber", "mm-1", "q_c; longer waves of the order grow on the isotropic state",
         of.neutral_wavenumber},
    };
}

std::vector<ResultRow> density_rows(const physics::Equations& equations) {
    const physics::ModelValues& model = equations.model;
    return {{"bead_density", "mm-2", "rho", number(model, "uniform.bead_density"), has_fields(model, {"rho"})},
            {"rod_density", "mm-2", "sigma", number(model, "uniform.rod_density"), has_fields(model, {"sigma"})}};
}

std::vector<std::string> stability_remarks(const physics::Equations& equations, const SlowOrder& values) {
    std::vector<std::string> remarks;
    if (has_noise(equations.model) && has_fields(equations.model, {"sigma"}) &&
        number(equations.model, "noise.rods") == 0.0)
        remarks.push_back(
            "noise.rods is 0: sigma has no shot noise, and DN^2/N tends to 0 in small boxes, to 1 for particles");
    for (const auto& [key, coefficient] : equations.coefficients)
        if (coefficient.table() && equations.model.table.outside == numerics::Outside::hold)
            remarks.push_back(text("outside its table ({}), {} keeps its value at the edge",
                                   physics::range_text(*coefficient.table()), key));
    for (const std::string& remark : function_remarks(equations)) remarks.push_back(remark);
    if (values.pressure_beads < 0.0 && has_fields(equations.model, {"rho"}))
        remarks.push_back(
            text("Abar = A + lambda E/Gamma = {:.4g} < 0 (E = {:.4g}): rods turn towards high bead "
                 "density, which makes most flocks unstable at an oblique angle",
                 values.pressure_beads, number(equations.model, "stiffness.beads")));
    return remarks;
}

std::string why_no_order(const physics::Equations& e) {
    const auto at = [&](const char* key) { return e.coefficient(key).at(mean_densities(e.model)); };
    if (!e.model.text_terms.empty()) return "";
    const bool flows = has_fields(e.model, {"v"});
    const double drag = flows ? at("drag.coefficient") : 1.0, alpha = flows ? at("driving.strength") : 0.0,
                 lambda = flows ? at("weathercock.strength") : 0.0, alpha_3 = flows ? at("driving.cubic") : 0.0;
    const bool is_pushed = source_kind(e.model) == physics::SourceKind::uniform;
    if (drag == 0.0 && (alpha != 0.0 || alpha_3 != 0.0))
        return lambda == 0.0 && is_pushed
                   ? "drag.coefficient is 0 and weathercock.strength is 0: driven beads accelerate without limit"
                   : "drag.coefficient is 0: driven beads accelerate without limit";
    if (drag == 0.0 && is_pushed)
        return "drag.coefficient is 0 and a force acts on the beads: they accelerate without limit";
    const double gain = drag == 0.0 ? 0.0 : lambda / drag;
    const double a = at("relaxation.rate") - gain * alpha, b = at("relaxation.saturation") - gain * alpha_3;
    if (a == 0.0 && b == 0.0) return "a - lambda alpha/Gamma and b are 0: every value of the order is stationary";
    if (b == 0.0 && a < 0.0)
        return text("a - lambda alpha/Gamma = {:.6g} /s < 0, but relaxation.saturation is 0: order grows without bound",
                    a);
    if (b < 0.0) return text("b - lambda alpha_3/Gamma is {:.6g} < 0: order grows without bound", b);
    if (a < 0.0) return "";  // none of these reasons
    return text("a - lambda alpha/Gamma = {:.6g} /s is not below 0", a);
}

double counterterm(const physics::ModelValues& model, const numerics::KeptGrid& on, const SourceLocation& where) {
    const IndependentRods rods(model);
    if (const auto why = rods.why_none()) fail_input(where, "approximation.counterterm with {}", *why);
    return 2.0 * rods.at(saturation_key) * rods.variance(on);
}

double part_of_waves(const physics::ModelValues& model, const numerics::KeptGrid& on) {
    const IndependentRods rods(model);
    if (rods.why_none()) return 0.0;
    return 2.0 * rods.at(saturation_key) * rods.variance(on) / rods.at(rate_key);
}

void add_counterterm(double rate, physics::ModelValues& model) { physics::number_in(model, rate_key) -= rate; }

}  // namespace drover::calibrate
