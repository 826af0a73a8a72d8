// run/model_coefficients.hpp: a declared model with other values of its coefficients.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "drover/model/equations.hpp"
#include "io/scene.hpp"

namespace drover::run {

/// The coefficient that a key names, "coefficients.a" or "a".  Throws an input Error at `where`, which begins with
/// `list`, for any other key.
std::string coefficient_of(const io::Scene& scene, const std::string& list, const std::string& key,
                           const SourceLocation& where);

/// Throws an input Error that names the values where the model has no equations with them.
model::Equations equations_with(const io::DeclaredModel& declared,
                                const std::vector<std::pair<std::string, double>>& changes);

}  // namespace drover::run
