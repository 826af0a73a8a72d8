// physics/function_terms.hpp: what a reader must know of terms that are functions of the calling program.
#pragma once
#include <string>
#include <vector>

#include "drover/physics/compiled_model.hpp"

namespace drover::physics {

/// "terms[1] is the Python function tilt, which this program does not have", of the first such term; "" if none.
std::string missing_function(const Model& model);

/// Of each function: that it is slow, how exact its linearisation is, and whether its degree is known.
std::vector<std::string> function_remarks(const CompiledModel& compiled);

}  // namespace drover::physics
