// tests/physics/full_model.hpp: a model with every term and every dependence, its forms, and the whole right-hand side.
#pragma once
#include <string>
#include <vector>

#include "physics/rod_bead_model.hpp"
#include "whole_rate.hpp"

namespace drover::physics {

/// Two components, dynamic velocity, every coefficient of order one, every dependence on the densities that a scene
/// can state.
inline Model full_model() {
    return {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
            .uniform = {.rod_density = 0.7, .bead_density = 1.3},
            .current = {.speed = 0.8, .kind = "density-order"},
            .inertia = {.bead_mass = 1.4, .advection = true},
            .drag = {.coefficient = 1.1, .coefficient_terms = {"0.3 rho", "0.2 sigma"}},
            .viscosity = {.shear = 0.23, .bulk = 0.11},
            .driving = {.strength = 0.9, .cubic = -0.3, .strength_terms = {"0.4 sigma", "-0.1 rho sigma"}},
            .stiffness = {.beads = 1.7, .rods = 0.6},
            .relaxation = {.rate = 0.4,
                           .rate_terms = {"-0.5 sigma", "0.2 rho^2"},
                           .saturation = 0.8,
                           .saturation_terms = {"0.3 rho"}},
            .elasticity = {.stiffness = 0.35, .splay = 0.15, .bilaplacian = 0.02},
            .weathercock = {.strength = 0.75, .strength_terms = {"-0.2 rho"}},
            .advection = {.strength = 0.55, .divergence = 0.4, .gradient = -0.3},
            .pressure = {.beads = 0.45, .rods = 0.65},
            .diffusion = {.beads = 0.05, .rods = 0.07},
            .noise = {},
            .force = {.kind = "uniform", .x = 0.3, .y = -0.2},
            .orienting_field = {.x = 0.1, .y = 0.25},
            .table = {}};
}

struct NamedModel {
    std::string name;
    Model model;
};

/// The full model in each form; what a form has no field for is left out.
inline std::vector<NamedModel> all_forms() {
    const Model full = full_model();
    std::vector<NamedModel> forms{{"two-component", full}};
    Model order_current = full;
    order_current.current.kind = "order";
    forms.push_back({"two-component, J = u p", order_current});
    Model dilute = full;
    dilute.fields.rod_density = false;
    dilute.current.speed = dilute.stiffness.rods = dilute.pressure.rods = dilute.diffusion.rods = 0.0;
    dilute.drag.coefficient_terms = {"0.3 rho"};
    dilute.driving.strength_terms = {"-0.1 rho^2"};
    dilute.relaxation.rate_terms = {"0.2 rho^2"};
    forms.push_back({"dilute", dilute});
    Model overdamped = full;
    overdamped.fields.bead_velocity = "slaved";
    overdamped.inertia.advection = false;
    overdamped.viscosity = {};
    forms.push_back({"overdamped, drag and driving by density", overdamped});
    Model viscous = overdamped;
    viscous.viscosity = full.viscosity;
    viscous.drag.coefficient_terms = viscous.driving.strength_terms = {};
    viscous.driving.cubic = 0.0;  // it needs the velocity on the grid
    forms.push_back({"overdamped, viscous", viscous});
    Model rods = full;
    rods.fields = {.bead_density = false, .rod_density = true, .bead_velocity = "absent"};
    rods.inertia.advection = false;
    rods.drag = {};
    rods.viscosity = {};
    rods.driving = {};
    rods.stiffness = {};
    rods.weathercock = {};
    rods.pressure.beads = rods.diffusion.beads = 0.0;
    rods.relaxation.rate_terms = {"-0.5 sigma"};
    rods.relaxation.saturation_terms = {"0.1 sigma"};
    rods.force.kind = "none";
    forms.push_back({"rods only", rods});
    Model polar = rods;
    polar.fields.rod_density = false;
    polar.current.speed = polar.pressure.rods = polar.diffusion.rods = 0.0;
    polar.relaxation.rate_terms = polar.relaxation.saturation_terms = {};
    forms.push_back({"polar", polar});
    Model steady = full;
    steady.fields.bead_density = false;
    steady.stiffness.beads = steady.pressure.beads = steady.diffusion.beads = 0.0;
    steady.drag.coefficient_terms = {"0.2 sigma"};
    steady.driving.strength_terms = {"0.4 sigma"};
    steady.relaxation.rate_terms = {"-0.5 sigma"};
    steady.relaxation.saturation_terms = steady.weathercock.strength_terms = {};
    forms.push_back({"rods and a dynamic velocity", steady});
    return forms;
}

/// The full model with coefficients from a table, which is no polynomial: products of it are cut off by the grid.
inline NamedModel tabulated() {
    Model measured = full_model();
    measured.table = {
        .bead_density = {0.4, 1.0, 1.6, 2.2},
        .rod_density = {0.2, 0.7, 1.5},
        .columns = {{"relaxation.rate", {{0.9, 0.7, 0.6, 0.6, 0.5, 0.3, 0.5, 0.4, 0.3, 0.4, 0.4, 0.1}, {}}},
                    {"driving.strength", {{0.7, 0.9, 0.8, 1.1, 1.0, 1.2, 1.3, 1.2, 1.5, 1.4, 1.7, 1.6}, {}}}}};
    measured.relaxation.rate_terms = measured.driving.strength_terms = {};
    return {"two-component, from a table", measured};
}

/// A model with one of its terms, and the current of the beads, which has no coefficient.
inline ModelValues with_one_term(ModelValues model, const std::string& term) {
    const ModelValues standard(*model.file);
    for (const CoefficientRow& row : model.file->coefficients) {
        if (row.needs.empty() || row.key() == term) continue;  // a mass is no term
        number_in(model, row.key()) = 0.0;
        model.monomials.erase(row.key());
        model.table.columns.erase(row.key());
    }
    for (const FieldRow& field : model.file->fields)
        for (const TermRow& row : field.terms)
            for (const std::string& key : row.on)
                if (row.key != term) model.values[key] = standard.values.at(key);
    for (std::size_t n = model.text_terms.size(); n > 0; --n)
        if (text("terms[{}]", n) != term) model.text_terms.erase(model.text_terms.begin() + static_cast<long>(n) - 1);
    return model;
}

}  // namespace drover::physics
