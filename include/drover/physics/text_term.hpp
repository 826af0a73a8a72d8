// physics/text_term.hpp: a term of the equations that a scene writes as text.
#pragma once
#include <string>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::physics {

/// One text of a term, with the location of its first character.
struct WrittenExpression {
    std::string text;
    SourceLocation where;
};

/// [[terms]] of a scene: a term of the equation of one field.
struct TextTerm {
    /// bead_density or rod_density (d_t of it), bead_velocity (a force per area [mg/(mm s^2)]: a term of m rho d_t v)
    /// or order (d_t p).
    std::string of;
    std::vector<WrittenExpression> value;  ///< of a density one, of a vector its x and y components
    std::vector<WrittenExpression> flux;   ///< of a density instead of a value: d_t = -div flux
    std::vector<std::string> parameters;   ///< names of its own numbers, in Model::parameters
    SourceLocation where;
};

}  // namespace drover::physics
