// physics/form.cpp: layout and component names of a form.
#include "drover/physics/form.hpp"

namespace drover::physics {

numerics::Layout layout(const Form& form) {
    return {.scalars = form.rod_density >= 0 ? 1 : 0, .vectors = form.polar_order >= 0 ? 1 : 0};
}

std::vector<Component> component_names(const Form& form) {
    std::vector<Component> names(static_cast<std::size_t>(numerics::components(layout(form))));
    if (form.rod_density >= 0)
        names[static_cast<std::size_t>(form.rod_density)] = {"rod_density", "mm-2", "rods per area, sigma"};
    if (form.polar_order >= 0) {
        const auto x = static_cast<std::size_t>(form.polar_order);
        names[x] = {"polar_order_x", "mm-2", "polar order density along x, p_x: rod density times mean orientation"};
        names[x + 1] = {"polar_order_y", "mm-2",
                        "polar order density along y, p_y: rod density times mean orientation"};
    }
    return names;
}

}  // namespace drover::physics
