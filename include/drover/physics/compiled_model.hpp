// physics/compiled_model.hpp: a model checked, with its fields in place and its coefficients as functions.
#pragma once
#include <string_view>
#include <utility>
#include <vector>

#include "drover/physics/coefficient_registry.hpp"
#include "drover/physics/form.hpp"

namespace drover::physics {

/// What terms are functions of.
struct CompiledModel : Coefficients {
    explicit CompiledModel(const Model& model);  ///< throws as check()
    /// The same, sharing the tables that `like` has made of the same numbers: for many models that differ in little.
    CompiledModel(const Model& model, const CompiledModel& like);

    Model model;
    Form form;
};

/// Throws an input Error, at its location, for numbers that cannot be: a coefficient of a field that the model does
/// not have, a polynomial that cannot be read, a table that does not fit, a slaved velocity without drag.
void check_numbers(const Model& model, const LocationOf& location_of = no_location,
                   const CoefficientRegistry& registry = coefficient_registry());

/// The coefficients that may depend on the densities, each with its key in the scene.
std::vector<std::pair<std::string_view, const Coefficient*>> named(const Coefficients& coefficients);

/// Throws an input Error where a coefficient has no value at these densities: beyond its table.
void require_values(const Coefficients& coefficients, double bead_density, double rod_density);

}  // namespace drover::physics
