// io/names_used.hpp: names that formulas have, and those that a model declares and does not use.
#pragma once
#include <string>
#include <vector>

#include "io/declared_model.hpp"

namespace drover::io {

/// Whether one of these names occurs in a formula.
bool mentions(const std::string& formula, const std::vector<std::string>& names);

/// Where a model declares what none of its equations has, directly or by another name: "coefficients.a", "define.mu",
/// "[[tabulated]] b".
std::vector<std::string> without_effect(const DeclaredModel& model);

}  // namespace drover::io
