// physics/program_functions.hpp: the terms that are functions of the calling program, linearised by differences, and
// the names in terms.
#pragma once
#include <map>
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

/// "terms[1] is the Python function tilt, which this program does not have", of the first such term; "" if none.
std::string missing_function(const ModelValues& model);

/// Of each function: that it is slow, how exact its linearisation is, and whether its degree is known.
std::vector<std::string> function_remarks(const CompiledModel& compiled);

/// The names that texts may use, and those that arguments of functions may have, with the formulas that they stand for.
std::map<std::string, std::string> text_names(const ModelValues& model);
std::map<std::string, std::string> argument_names(const ModelValues& model);

}  // namespace drover::physics
