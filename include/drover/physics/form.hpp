// physics/form.hpp: the fields of a model (its form) and their component indices.
#pragma once
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/numerics/field.hpp"

namespace drover::physics {

/// The fields of a model, as given in a scene.  The polar order is always present.
struct FieldChoice {
    bool bead_density = false;             ///< rho
    bool rod_density = true;               ///< sigma
    std::string bead_velocity = "absent";  ///< v: dynamic, slaved or absent
    bool operator==(const FieldChoice&) const = default;
};

enum class Velocity {
    absent,
    slaved,  ///< determined at every instant by the force balance: not an independent field
    dynamic
};

/// A set of fields.  Each number is the index of the first component of that field in Fields and Spectra, or -1 if the
/// field is absent.
struct Form {
    int bead_density = -1;   ///< rho
    int rod_density = -1;    ///< sigma
    int bead_velocity = -1;  ///< v, two components, if dynamic
    int polar_order = -1;    ///< p, two components
    Velocity velocity = Velocity::absent;
    bool order_is_density = false;  ///< p is sigma times the mean orientation [1/mm^2], not the mean orientation itself
};

Form make_form(const FieldChoice& fields, bool order_is_density);

/// Rods alone; p is the order density.
inline constexpr Form rods_only{.rod_density = 0, .polar_order = 1, .order_is_density = true};

numerics::Layout layout(const Form& form);

/// By its symbol in equations.
bool has_field(const Form& form, const std::string& symbol);

/// Readable name: "two-component", "dilute", "overdamped", "rods only", "polar", or else the list of fields.
std::string form_name(const Form& form);

/// One component, as named in files and messages.
struct Component {
    std::string name;     ///< rod_density, polar_order_x, ...
    std::string unit;     ///< UDUNITS text
    std::string meaning;  ///< description with its symbol
};
std::vector<Component> component_names(const Form& form);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::FieldChoice>>& schema<physics::FieldChoice>();
}  // namespace drover
