// theory/state_names.hpp: uniform states in words, and their names.
#pragma once
#include <string>
#include <vector>

#include "drover/theory/theory.hpp"

namespace drover::theory {

class UniformEquations;

/// A density that the scene gives.
bool is_given(const model::Field& field);

/// "|p| = 0.5, |v| = 0.1": the values of a state but 0 and but those that the scene gives, as fields are drawn.
std::string values_text(const model::Model& model, const model::UniformState& values);
/// The same, or "all fields 0".
std::string state_text(const model::Model& model, const model::UniformState& values);

/// "ordered, phi = 0.3, |p| = 0.5".
std::string state_words(const model::Model& model, const StationaryState& state);

/// Names states that are sorted.  Those along a direction that the equations name are then sorted from the largest
/// order along it to the largest against it.
void name_states(const UniformEquations& equations, std::vector<StationaryState>& states);

}  // namespace drover::theory
