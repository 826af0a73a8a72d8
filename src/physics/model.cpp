// physics/model.cpp: the form of a model, and the keys of its mean densities.
#include "drover/physics/model.hpp"

namespace drover::physics {

Form form(const Model& model) {
    return make_form(model.fields, model.fields.rod_density && model.current.kind == "order");
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>() {
    static const std::vector<Row<physics::UniformState>> rows{
        {.name = "rod_density",
         .member = &physics::UniformState::rod_density,
         .unit = "1/mm^2",
         .range = positive,
         .doc = "sigma: mean density of the rods, which the equations conserve"},
        {.name = "bead_density",
         .member = &physics::UniformState::bead_density,
         .unit = "1/mm^2",
         .range = positive,
         .doc = "rho: mean density of the beads, which the equations conserve"},
        {.name = "rod_area",
         .member = &physics::UniformState::rod_area,
         .unit = "mm^2",
         .range = not_negative,
         .doc = "projected area of one rod, for area fractions; 0: unknown"},
        {.name = "bead_area",
         .member = &physics::UniformState::bead_area,
         .unit = "mm^2",
         .range = not_negative,
         .doc = "projected area of one bead, for area fractions; 0: unknown"}};
    return rows;
}

}  // namespace drover
