// physics/form.hpp: which fields a model has (its form), and where each stands among the components.
#pragma once
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/numerics/field.hpp"

namespace drover::physics {

/// The fields of a model, as a scene says them; the polar order is always one of them.
struct FieldChoice {
    bool bead_density = false;             ///< rho
    bool rod_density = true;               ///< sigma
    std::string bead_velocity = "absent";  ///< v: dynamic, slaved or absent
};

enum class Velocity {
    absent,
    slaved,  ///< in balance with the forces on it at every moment: no field of its own
    dynamic
};

/// A form is a set of fields; each number is the first component of that field in Fields and Spectra, -1 when absent.
struct Form {
    int bead_density = -1;   ///< rho
    int rod_density = -1;    ///< sigma
    int bead_velocity = -1;  ///< v, two components, when dynamic
    int polar_order = -1;    ///< p, two components
    Velocity velocity = Velocity::absent;
    bool order_is_density = false;  ///< p is sigma times the mean orientation [1/mm^2], not the mean orientation itself
};

Form make_form(const FieldChoice& fields, bool order_is_density);

/// Rods alone, p being the order density.
inline constexpr Form rods_only{.rod_density = 0, .polar_order = 1, .order_is_density = true};

numerics::Layout layout(const Form& form);

/// "two-component", "dilute", "overdamped", "rods only", "polar", or the fields themselves: for people.
std::string form_name(const Form& form);

/// One component, as files and messages name it.
struct Component {
    std::string name;     ///< rod_density, polar_order_x, ...
    std::string unit;     ///< UDUNITS text
    std::string meaning;  ///< for people, with its symbol
};
std::vector<Component> component_names(const Form& form);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::FieldChoice>>& schema<physics::FieldChoice>();
}  // namespace drover
