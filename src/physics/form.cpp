// physics/form.cpp: layout and component names of a form.
#include "drover/physics/form.hpp"

#include "model_file.hpp"

namespace drover::physics {

Form make_form(const FieldChoice& fields, bool order_is_density) {
    Form form;
    int next = 0;
    if (fields.bead_density) form.bead_density = next++;
    if (fields.rod_density) form.rod_density = next++;
    if (fields.bead_velocity == "slaved") form.velocity = Velocity::slaved;
    if (fields.bead_velocity == "dynamic") {
        form.velocity = Velocity::dynamic;
        form.bead_velocity = next;
        next += 2;
    }
    form.polar_order = next;
    form.order_is_density = order_is_density;
    return form;
}

numerics::Layout layout(const Form& form) {
    return numerics::scalars_and_vectors((form.bead_density >= 0 ? 1 : 0) + (form.rod_density >= 0 ? 1 : 0),
                                         (form.bead_velocity >= 0 ? 1 : 0) + (form.polar_order >= 0 ? 1 : 0));
}

std::string form_name(const Form& form) {
    const bool beads = form.bead_density >= 0, rods = form.rod_density >= 0;
    if (beads && form.velocity == Velocity::dynamic) return rods ? "two-component" : "dilute";
    if (beads && rods && form.velocity == Velocity::slaved) return "overdamped";
    if (!beads && form.velocity == Velocity::absent) return rods ? "rods only" : "polar";
    const char* velocity = form.velocity == Velocity::dynamic  ? ", dynamic bead velocity"
                           : form.velocity == Velocity::slaved ? ", slaved bead velocity"
                                                               : "";
    return text("polar order{}{}{}", beads ? ", bead density" : "", rods ? ", rod density" : "", velocity);
}

bool has_field(const Form& form, const std::string& symbol) {
    if (symbol == "rho") return form.bead_density >= 0;
    if (symbol == "sigma") return form.rod_density >= 0;
    return symbol == "p" ? form.polar_order >= 0 : form.velocity != Velocity::absent;
}

std::vector<Component> component_names(const Form& form) {
    std::vector<Component> names;
    for (const RodBead::Field& row : rod_bead().fields) {
        const bool follows = row.symbol == "v" && form.velocity != Velocity::dynamic;
        if (follows || !has_field(form, row.symbol)) continue;
        const model::Field field{.name = row.name, .symbol = row.symbol, .spin = row.spin};
        const std::vector<std::string> components = model::dataset_names(field),
                                       symbols = model::component_names(field);
        for (std::size_t part = 0; part < components.size(); ++part)
            names.push_back(
                {components[part], unit_of(row, form.order_is_density), row.meaning + ", " + symbols[part]});
    }
    return names;
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::FieldChoice>>& schema<physics::FieldChoice>() {
    using physics::FieldChoice;
    static const std::vector<Row<FieldChoice>> rows{
        {.name = "bead_density",
         .member = &FieldChoice::bead_density,
         .doc = "rho, the density of the beads, is a field"},
        {.name = "rod_density",
         .member = &FieldChoice::rod_density,
         .doc = "sigma, the density of the rods, is a field"},
        {.name = "bead_velocity",
         .member = &FieldChoice::bead_velocity,
         .choices = {"dynamic", "slaved", "absent"},
         .doc = "v: dynamic: with inertia; slaved: from the instantaneous force balance"}};
    return rows;
}

}  // namespace drover
