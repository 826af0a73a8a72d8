// physics/text_term.hpp: a term of the equations given as text in a scene, or by a function of the calling program.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/model/model.hpp"

namespace drover::physics {

using model::PointArgument;

/// Adds the two components of a term at points.  It calls the function of the program from one thread at a time, and
/// throws what that throws.
using PointFunction =
    std::function<void(std::size_t size, std::span<const PointArgument> arguments, std::span<double* const> out)>;

/// The functions of the calling program by the number of their term, from 1.
using TermFunctions = std::map<std::size_t, std::shared_ptr<const PointFunction>>;

/// An entry of [[terms]] in a scene: a term in the equation of one field.
struct TextTerm {
    /// bead_density or rod_density (d_t of it), bead_velocity (a force per area [mg/(mm s^2)]: a term of m rho d_t v)
    /// or order (d_t p).
    std::string of;
    std::vector<model::Text> value;       ///< one for a density; the x and y components for a vector
    std::vector<model::Text> flux;        ///< alternative to value, densities only: d_t = -div flux
    std::vector<std::string> parameters;  ///< names of its parameters, in Model::parameters
    bool is_explicit = false;             ///< nothing of it is in the exact linear part
    SourceLocation where;

    std::string function;                       ///< name of a function instead of texts; empty: none
    std::vector<std::string> arguments;         ///< of the function: inputs and parameters by name, in their order
    int degree = 0;                             ///< of the function as a polynomial in the fields; 0: not known
    std::string source;                         ///< of the function, for the record
    std::shared_ptr<const PointFunction> call;  ///< nullptr in a program that does not have the function
};

}  // namespace drover::physics
