// physics/term_names.hpp: names in the terms of a scene, and what they are in the model file.
#pragma once
#include <array>
#include <map>
#include <string>

#include "drover/physics/form.hpp"

namespace drover::physics {

/// An equation that a term can be of, and the symbol of its field.
struct TermTarget {
    const char *of, *symbol;
    bool is_scalar;
};
inline constexpr std::array term_targets{TermTarget{"bead_density", "rho", true},
                                         TermTarget{"rod_density", "sigma", true},
                                         TermTarget{"bead_velocity", "v", false}, TermTarget{"order", "p", false}};

/// The names that texts may use, and those that arguments of functions may have, with the formulas that they stand for.
std::map<std::string, std::string> text_names(const Form& form);
std::map<std::string, std::string> argument_names(const Form& form);

}  // namespace drover::physics
