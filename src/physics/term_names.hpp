// physics/term_names.hpp: names in the terms of a scene, and what they are in the model file.
#pragma once
#include <map>
#include <string>

#include "physics/model_values.hpp"

namespace drover::physics {

/// The names that texts may use, and those that arguments of functions may have, with the formulas that they stand for.
std::map<std::string, std::string> text_names(const ModelValues& model);
std::map<std::string, std::string> argument_names(const ModelValues& model);

}  // namespace drover::physics
