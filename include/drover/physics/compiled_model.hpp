// physics/compiled_model.hpp: a validated model with its field layout and its coefficients as functions.
#pragma once
#include <string_view>
#include <utility>
#include <vector>

#include "drover/physics/coefficient_registry.hpp"
#include "drover/physics/form.hpp"

namespace drover::physics {

/// The input of every term.
struct CompiledModel : Coefficients {
    explicit CompiledModel(const Model& model);  ///< throws as check()
    /// Shares the tables of `like` where their data are equal; saves time when many models differ in few values.
    CompiledModel(const Model& model, const CompiledModel& like);

    Model model;
    Form form;
};

/// Throws an input Error, with its location, for invalid parameters: a coefficient of an absent field, a malformed
/// polynomial, an inconsistent table, a slaved velocity without drag.
void check_numbers(const Model& model, const LocationOf& location_of = no_location,
                   const CoefficientRegistry& registry = coefficient_registry());

/// The coefficients that may depend on the densities, each with its scene key.
std::vector<std::pair<std::string_view, const Coefficient*>> named(const Coefficients& coefficients);

/// Throws an input Error if these densities are outside the table of a coefficient.
void require_values(const Coefficients& coefficients, double bead_density, double rod_density);

}  // namespace drover::physics
