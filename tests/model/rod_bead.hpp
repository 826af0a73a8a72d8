// tests/model/rod_bead.hpp: the rod-bead equations as text, for comparison with the built-in terms.
#pragma once
#include <string>

#include "drover/model/equations.hpp"
#include "drover/physics/model.hpp"

namespace drover::model {

/// "alpha_0 + 0.4 sigma".
inline std::string dependent(const std::string& symbol, const std::vector<std::string>& monomials) {
    std::string result = symbol + "_0";
    for (const std::string& monomial : monomials) result += " + (" + monomial + ")";
    return result;
}

/// The equations of the built-in model of the same fields, every coefficient included.
inline Model rod_bead(const physics::Model& m) {
    Model result;
    const bool rho = m.fields.bead_density, sigma = m.fields.rod_density, moves = m.fields.bead_velocity != "absent",
               slaved = m.fields.bead_velocity == "slaved";
    const std::string beads = rho ? " - E grad rho" : "", rods = sigma ? " - F grad sigma" : "";
    if (rho)
        result.fields.push_back({.name = "bead_density",
                                 .symbol = "rho",
                                 .equation = {moves ? "-div(rho v) + D_rho lap rho" : "D_rho lap rho", {"test", 1, 1}},
                                 .conserved = true,
                                 .reference = m.uniform.bead_density});
    if (sigma)
        result.fields.push_back({.name = "rod_density",
                                 .symbol = "sigma",
                                 .equation = {"-div(J) + D_sigma lap sigma", {"test", 2, 1}},
                                 .conserved = true,
                                 .reference = m.uniform.rod_density});
    const std::string carried = !m.inertia.advection || slaved ? "" : rho ? " - m rho v.grad v" : " - m rho_0 v.grad v";
    if (moves)
        result.fields.push_back({.name = "bead_velocity",
                                 .symbol = "v",
                                 .spin = 1,
                                 .left = slaved ? LeftSide::balance : LeftSide::rate,
                                 .mass = {slaved ? ""
                                          : rho  ? "m rho"
                                                 : "m rho_0",
                                          {"test", 3, 100}},
                                 .equation = {"-Gamma v + eta lap v + zeta grad(div v) + (alpha + alpha_3 p.p) p" +
                                                  beads + rods + carried + " + f_x e_x + f_y e_y",
                                              {"test", 3, 1}}});
    result.fields.push_back(
        {.name = "polar_order",
         .symbol = "p",
         .spin = 1,
         .equation = {"-w p.grad p - lambda_2 p div p - lambda_3 grad(p.p) - (a + b p.p) p + K3 lap p + K1 grad(div p)"
                      " - K4 lap lap p" +
                          std::string(moves ? " + lambda v" : "") + (rho ? " - A grad rho" : "") +
                          (sigma ? " - B grad sigma" : "") + " + h_x e_x + h_y e_y",
                      {"test", 4, 1}}});
    const bool uniform_force = m.force.kind == "uniform";
    result.coefficients = {{"u", m.current.speed},
                           {"m", m.inertia.bead_mass},
                           {"rho_0", m.uniform.bead_density},
                           {"Gamma_0", m.drag.coefficient},
                           {"eta", m.viscosity.shear},
                           {"zeta", m.viscosity.bulk},
                           {"alpha_0", m.driving.strength},
                           {"alpha_3", m.driving.cubic},
                           {"E", m.stiffness.beads},
                           {"F", m.stiffness.rods},
                           {"a_0", m.relaxation.rate},
                           {"b_0", m.relaxation.saturation},
                           {"K3", m.elasticity.stiffness},
                           {"K1", m.elasticity.splay},
                           {"K4", m.elasticity.bilaplacian},
                           {"lambda_0", m.weathercock.strength},
                           {"w", m.advection.strength},
                           {"lambda_2", m.advection.divergence},
                           {"lambda_3", m.advection.gradient},
                           {"A", m.pressure.beads},
                           {"B", m.pressure.rods},
                           {"D_rho", m.diffusion.beads},
                           {"D_sigma", m.diffusion.rods},
                           {"f_x", uniform_force ? m.force.x : 0.0},
                           {"f_y", uniform_force ? m.force.y : 0.0},
                           {"h_x", m.orienting_field.x},
                           {"h_y", m.orienting_field.y}};
    result.definitions = {{"Gamma", {dependent("Gamma", m.drag.coefficient_terms), {}}},
                          {"alpha", {dependent("alpha", m.driving.strength_terms), {}}},
                          {"a", {dependent("a", m.relaxation.rate_terms), {}}},
                          {"b", {dependent("b", m.relaxation.saturation_terms), {}}},
                          {"lambda", {dependent("lambda", m.weathercock.strength_terms), {}}}};
    if (sigma) result.definitions.push_back({"J", {m.current.kind == "order" ? "u p" : "u sigma p", {}}});
    return result;
}

}  // namespace drover::model
