// tests/physics/text_terms.hpp: models whose terms are written as text.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "physics/rod_bead_model.hpp"

namespace drover::physics {

inline TextTerm text_term(const std::string& of, const std::vector<std::string>& value,
                          const std::vector<std::string>& flux = {}) {
    TextTerm term{.of = of, .where = {}};
    for (const std::string& one : value) term.value.push_back({one, {}});
    for (const std::string& one : flux) term.flux.push_back({one, {}});
    return term;
}

/// Adds terms of every kind to a model with rods: products, gradients, functions, anisotropic and density-dependent
/// ones.
inline Model with_texts(Model model) {
    model.parameters = {{"W", 0.7}, {"c", 0.4}};
    model.text_terms = {text_term("order", {"-W order_x order_y^2", "W order_x^2 order_y"}),
                        text_term("order", {"0", "-W order_y"}),
                        text_term("order", {"-c order_x div order", "-c order_y div order"}),
                        text_term("order",
                                  {"0.1 tanh(order_x) lap order_y", "0.2 d_x order_y d_y order_x - 0.3 order_y"})};
    if (model.fields.rod_density) {
        model.text_terms.push_back(text_term("rod_density", {}, {"0.3 order_x rod_density^2", "-0.1 d_y rod_density"}));
        model.text_terms.push_back(
            text_term("rod_density", {"0.2 order_x d_x rod_density + 0.2 rod_density d_x order_x"}));
        model.text_terms.push_back(
            text_term("order", {"0.2 rod_density order_x - 0.1 d_x rod_density", "0.2 rod_density order_y"}));
    }
    if (model.fields.bead_density)
        model.text_terms.push_back(text_term("order", {"0.2 d_x bead_density", "0.3 bead_density curl order"}));
    if (model.fields.bead_velocity == "dynamic")
        model.text_terms.push_back(
            text_term("bead_velocity", {"-c (bead_velocity_x^2 + bead_velocity_y^2) bead_velocity_x + 0.2 order_x^2",
                                        "0.3 bead_velocity_x + 0.1 lap bead_velocity_y"}));
    if (model.fields.bead_velocity == "slaved" && model.viscosity.shear == 0.0)
        model.text_terms.push_back(text_term("bead_velocity", {"-c order_x^2 order_x", "0.2 order_x"}));
    if (model.fields.bead_velocity != "absent")
        model.text_terms.push_back(text_term("order", {"0.1 bead_velocity_y", "0.2 bead_velocity_x order_y"}));
    return model;
}

}  // namespace drover::physics
