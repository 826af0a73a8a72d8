// physics/text_term.hpp: a term of the equations given as text in a scene.
#pragma once
#include <string>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::physics {

/// One expression of a term, with the location of its first character.
struct WrittenExpression {
    std::string text;
    SourceLocation where;
};

/// An entry of [[terms]] in a scene: a term in the equation of one field.
struct TextTerm {
    /// bead_density or rod_density (d_t of it), bead_velocity (a force per area [mg/(mm s^2)]: a term of m rho d_t v)
    /// or order (d_t p).
    std::string of;
    std::vector<WrittenExpression> value;  ///< one for a density; the x and y components for a vector
    std::vector<WrittenExpression> flux;   ///< alternative to value, densities only: d_t = -div flux
    std::vector<std::string> parameters;   ///< names of its parameters, in Model::parameters
    SourceLocation where;
};

}  // namespace drover::physics
