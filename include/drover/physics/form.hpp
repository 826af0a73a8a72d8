// physics/form.hpp: which fields a model has (its form), and where each stands among the components.
#pragma once
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"

namespace drover::physics {

/// A form is a set of fields; each number is the first component of that field in Fields and Spectra, -1 when absent.
struct Form {
    int rod_density = -1;  ///< sigma
    int polar_order = -1;  ///< p, two components
};

/// Rods alone: sigma and p.
inline constexpr Form rods_only{.rod_density = 0, .polar_order = 1};

numerics::Layout layout(const Form& form);

/// One component, as files and messages name it.
struct Component {
    std::string name;     ///< rod_density, polar_order_x, ...
    std::string unit;     ///< UDUNITS text
    std::string meaning;  ///< for people, with its symbol
};
std::vector<Component> component_names(const Form& form);

}  // namespace drover::physics
