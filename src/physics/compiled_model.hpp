// physics/compiled_model.hpp: a validated model with its coefficients as functions of the densities.
#pragma once
#include <map>
#include <string>

#include "physics/model_values.hpp"

namespace drover::physics {

/// The input of every term.
struct CompiledModel {
    /// Throws an input Error, with its location, for invalid parameters: a coefficient of an absent field, a malformed
    /// polynomial, an inconsistent table.  Shares the tables of `like` where their data are equal: saves time when many
    /// models differ in few values.
    explicit CompiledModel(const ModelValues& model, const Locate& locate = no_location,
                           const CompiledModel* like = nullptr);

    const Coefficient& coefficient(const std::string& key) const { return coefficients.at(key); }

    ModelValues model;
    std::map<std::string, Coefficient> coefficients;  ///< by key
};

/// Whether the mass of a field is proportional to a density of the file.
bool is_in_mass(const FieldRow& field, const FieldRow& density);
/// The other factors of the mass of a field: coefficients, and densities that are no fields.
double mass_factor(const CompiledModel& model, const FieldRow& field);

/// Throws an input Error if these densities are outside the table of a coefficient.
void require_values(const CompiledModel& model, const Densities& densities);

}  // namespace drover::physics
