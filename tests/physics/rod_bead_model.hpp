// tests/physics/rod_bead_model.hpp: a model of rods and beads as C++ writes it best, with its equations as comments:
//
//     d_t sigma     = -div J + D_sigma lap sigma + noise,    J = u p  or  u sigma p
//     d_t rho       = -div(rho v) + D_rho lap rho + noise
//     m rho d_t v   = -m rho v.grad v [optional] - Gamma v + eta lap v + zeta grad(div v)
//                     + (alpha + alpha_3 |p|^2) p - E grad rho - F grad sigma + force + noise
//     d_t p         = -w p.grad p - (a - c sigma + b |p|^2) p + K3 lap p + K1 grad(div p) - K4 lap^2 p
//                     + lambda v - A grad rho - B grad sigma - lambda_2 p div p - lambda_3 grad |p|^2
//                     + orienting field + noise
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "physics/equations.hpp"

namespace drover::physics {

/// The components of a model that has all fields.
struct FieldIndex {
    enum Value : int {
        bead_density,
        rod_density,
        bead_velocity_x,
        bead_velocity_y,
        polar_order_x,
        polar_order_y,
        count
    };
};

/// Of a component in equations; -1: not there.
inline int component(const Equations& equations, int field) {
    constexpr std::array symbols{"rho", "sigma", "v", "v", "p", "p"};
    const int first = equations.component(symbols[static_cast<std::size_t>(field)]);
    const bool is_second = field == FieldIndex::bead_velocity_y || field == FieldIndex::polar_order_y;
    return first < 0 ? -1 : first + (is_second ? 1 : 0);
}

enum class Velocity { absent, slaved, dynamic };

/// The first component of each field with a rate; -1: not there.
struct Form {
    int bead_density = -1, rod_density = -1, bead_velocity = -1, polar_order = -1;
    Velocity velocity = Velocity::absent;
    bool order_is_density = false;
};
/// Rods alone; p is the order density.
inline constexpr Form rods_only{.rod_density = 0, .polar_order = 1, .order_is_density = true};
inline Form form(const ModelValues& model) {
    Form form;
    int next = 0;
    if (presence(model, "rho") == Presence::rate) form.bead_density = next++;
    if (presence(model, "sigma") == Presence::rate) form.rod_density = next++;
    if (presence(model, "v") == Presence::balance) form.velocity = Velocity::slaved;
    if (presence(model, "v") == Presence::rate) {
        form.velocity = Velocity::dynamic;
        form.bead_velocity = next;
        next += 2;
    }
    form.polar_order = next;
    form.order_is_density = order_is_density(model);
    return form;
}
inline numerics::Layout layout(const Form& form) {
    return numerics::scalars_and_vectors((form.bead_density >= 0 ? 1 : 0) + (form.rod_density >= 0 ? 1 : 0),
                                         form.bead_velocity >= 0 ? 2 : 1);
}

struct FieldChoice {
    bool bead_density = false, rod_density = true;
    std::string bead_velocity = "absent";
};
struct UniformState {
    double rod_density = 1.0, bead_density = 1.0, rod_area = 0.0, bead_area = 0.0;
};
inline UniformState uniform_of(const ModelValues& model) {
    return {.rod_density = number(model, "uniform.rod_density"),
            .bead_density = number(model, "uniform.bead_density"),
            .rod_area = number(model, "uniform.rod_area"),
            .bead_area = number(model, "uniform.bead_area")};
}
using Monomials = std::vector<std::string>;
struct RodCurrent {
    double speed = 0.0;
    std::string kind = "order";
};
struct Inertia {
    double bead_mass = 1.0;
    bool advection = false;
};
struct Drag {
    double coefficient = 0.0;
    Monomials coefficient_terms;
};
struct Viscosity {
    double shear = 0.0, bulk = 0.0;
};
struct Driving {
    double strength = 0.0, cubic = 0.0;
    Monomials strength_terms;
};
struct Stiffness {
    double beads = 0.0, rods = 0.0;
};
struct Relaxation {
    double rate = 1.0;
    Monomials rate_terms;
    double saturation = 0.0;
    Monomials saturation_terms;
    double contact = 0.0;
};
struct Elasticity {
    double stiffness = 0.0, splay = 0.0, bilaplacian = 0.0;
};
struct Weathercock {
    double strength = 0.0;
    Monomials strength_terms;
    std::string convention = "mean";
};
struct SelfAdvection {
    double strength = 0.0, divergence = 0.0, gradient = 0.0;
};
struct Pressure {
    double beads = 0.0, rods = 0.0;
};
struct Diffusion {
    double beads = 0.0, rods = 0.0;
};
struct Noise {
    double order = 0.0, velocity = 0.0, rods = 0.0, beads = 0.0;
};
struct BodyForce {
    std::string kind = "none";
    double x = 0.0, y = 0.0, at_x = 0.0, at_y = 0.0, velocity_x = 0.0, velocity_y = 0.0, width = 0.0;
};
struct OrientingField {
    double x = 0.0, y = 0.0;
};
struct DensityTable {
    std::vector<double> bead_density, rod_density;
    std::map<std::string, TableColumn> columns;
    numerics::Outside outside = numerics::Outside::refuse;
};

struct Model {
    FieldChoice fields;
    UniformState uniform;
    RodCurrent current;
    Inertia inertia;
    Drag drag;
    Viscosity viscosity;
    Driving driving;
    Stiffness stiffness;
    Relaxation relaxation;
    Elasticity elasticity;
    Weathercock weathercock;
    SelfAdvection advection;
    Pressure pressure;
    Diffusion diffusion;
    Noise noise;
    BodyForce force;
    OrientingField orienting_field;
    DensityTable table;
    std::vector<TextTerm> text_terms;
    std::map<std::string, double> parameters;

    operator ModelValues() const;  // NOLINT: where the library takes values by key, tests have this
};

/// Calls see(key, member) for each number, word and switch.
template <class M, class See>
void visit_keys(M& m, See see) {
    see("uniform.rod_density", m.uniform.rod_density);
    see("uniform.bead_density", m.uniform.bead_density);
    see("uniform.rod_area", m.uniform.rod_area);
    see("uniform.bead_area", m.uniform.bead_area);
    see("current.speed", m.current.speed);
    see("inertia.bead_mass", m.inertia.bead_mass);
    see("drag.coefficient", m.drag.coefficient);
    see("viscosity.shear", m.viscosity.shear);
    see("viscosity.bulk", m.viscosity.bulk);
    see("driving.strength", m.driving.strength);
    see("driving.cubic", m.driving.cubic);
    see("stiffness.beads", m.stiffness.beads);
    see("stiffness.rods", m.stiffness.rods);
    see("relaxation.rate", m.relaxation.rate);
    see("relaxation.saturation", m.relaxation.saturation);
    see("relaxation.contact", m.relaxation.contact);
    see("elasticity.stiffness", m.elasticity.stiffness);
    see("elasticity.splay", m.elasticity.splay);
    see("elasticity.bilaplacian", m.elasticity.bilaplacian);
    see("weathercock.strength", m.weathercock.strength);
    see("advection.strength", m.advection.strength);
    see("advection.divergence", m.advection.divergence);
    see("advection.gradient", m.advection.gradient);
    see("pressure.beads", m.pressure.beads);
    see("pressure.rods", m.pressure.rods);
    see("diffusion.beads", m.diffusion.beads);
    see("diffusion.rods", m.diffusion.rods);
    see("noise.order", m.noise.order);
    see("noise.velocity", m.noise.velocity);
    see("noise.rods", m.noise.rods);
    see("noise.beads", m.noise.beads);
    see("force.x", m.force.x);
    see("force.y", m.force.y);
    see("force.at_x", m.force.at_x);
    see("force.at_y", m.force.at_y);
    see("force.velocity_x", m.force.velocity_x);
    see("force.velocity_y", m.force.velocity_y);
    see("force.width", m.force.width);
    see("orienting_field.x", m.orienting_field.x);
    see("orienting_field.y", m.orienting_field.y);
    see("fields.bead_density", m.fields.bead_density);
    see("fields.rod_density", m.fields.rod_density);
    see("fields.bead_velocity", m.fields.bead_velocity);
    see("current.kind", m.current.kind);
    see("inertia.advection", m.inertia.advection);
    see("weathercock.convention", m.weathercock.convention);
    see("force.kind", m.force.kind);
}

/// Calls see(key, member) for the monomials of each coefficient that has some.
template <class M, class See>
void visit_monomials(M& m, See see) {
    see("drag.coefficient", m.drag.coefficient_terms);
    see("driving.strength", m.driving.strength_terms);
    see("relaxation.rate", m.relaxation.rate_terms);
    see("relaxation.saturation", m.relaxation.saturation_terms);
    see("weathercock.strength", m.weathercock.strength_terms);
}

inline Model::operator ModelValues() const {
    ModelValues to;
    visit_keys(*this, [&](const char* key, const auto& value) { to.values.at(key) = value; });
    visit_monomials(*this, [&](const char* key, const Monomials& written) { to.monomials[key] = written; });
    to.table = {.nodes = {table.bead_density, table.rod_density}, .columns = table.columns, .outside = table.outside};
    to.text_terms = text_terms;
    to.parameters = parameters;
    return to;
}

inline Model written(const ModelValues& from) {
    Model model;
    visit_keys(model, [&](const char* key, auto& value) {
        value = std::get<std::remove_cvref_t<decltype(value)>>(from.values.at(key));
    });
    visit_monomials(model, [&](const char* key, Monomials& texts) { texts = monomials_of(from, key); });
    model.table = {.bead_density = from.table.nodes[0],
                   .rod_density = from.table.nodes[1],
                   .columns = from.table.columns,
                   .outside = from.table.outside};
    model.text_terms = from.text_terms;
    model.parameters = from.parameters;
    return model;
}

}  // namespace drover::physics
