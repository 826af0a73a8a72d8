// physics/compiled_function.hpp: the terms that are functions of the calling program, linearised by differences.
#pragma once
#include <string>
#include <vector>

#include "drover/physics/term.hpp"

namespace drover::physics {

/// A term that is a function, evaluated at points.  Where the program does not have the function, its use throws
/// missing_function().  Throws an input Error for arguments that the form does not have.
Term compiled_function(const CompiledModel& model, const TextTerm& written, std::size_t number,
                       bool pointwise_velocity);

/// Throws an input Error unless every function of a model is there, depends on its arguments point by point, is finite
/// near the uniform state, and has its degree.
void check_functions(const CompiledModel& model);

}  // namespace drover::physics
