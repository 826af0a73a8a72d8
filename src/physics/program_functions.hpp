// physics/program_functions.hpp: the terms that are functions of the calling program, linearised by differences.
#pragma once
#include <string>
#include <vector>

#include "drover/model/model.hpp"
#include "physics/compiled_model.hpp"

namespace drover::physics {

struct ProgramFunction {
    struct Argument {
        enum class Kind { field, position, number };
        Kind kind = Kind::field;
        double value = 0.0;  ///< in the uniform state
        double scale = 1.0;  ///< a change that is neither small nor large
        bool is_density = false;
    };
    std::string name = {};  ///< "terms[1], the Python function tilt"
    TextTerm written = {};
    std::vector<Argument> arguments = {};
};

/// Throws an input Error for arguments that the form does not have.
ProgramFunction program_function(const CompiledModel& model, const TextTerm& written, std::size_t number);

/// Where the program does not have the function, its values and slopes are NaN.
model::GivenFunction given_function(const ProgramFunction& function);

/// Throws an input Error where the program does not have a function of the model.
void require_functions(const ModelValues& model);

/// Throws an input Error unless every function of a model is there, depends on its arguments point by point, is finite
/// near the uniform state, and has its degree.
void check_functions(const CompiledModel& model);

}  // namespace drover::physics
