// run/field_moment.cpp: transforms of a state for its observables.
#include "run/field_moment.hpp"

#include <algorithm>
#include <utility>

#include "drover/physics/right_hand_side.hpp"

namespace drover::run {

void to_grid(const physics::FieldEvolution& evolution, numerics::Transform& transform, double time,
             const numerics::Spectra& state, FieldsOnGrid& to) {
    const physics::Form& form = evolution.equations().form;
    const numerics::Grid& grid = evolution.system().grid;
    if (to.fields.size == 0) to.fields = numerics::Fields(grid, state.count());
    transform.backward(state, to.fields);
    if (form.velocity == physics::Velocity::absent) return;
    if (to.velocity.size == 0) to.velocity = numerics::Spectra(grid, 2);
    if (form.velocity == physics::Velocity::slaved) {
        numerics::Fields now = physics::slaved_velocity(evolution.equations(), evolution.system(), time, state);
        if (to.slaved.size == 0) to.slaved = std::move(now);
        else std::copy(now.values.begin(), now.values.end(), to.slaved.values.begin());
        transform.forward(to.slaved, to.velocity);
        return;
    }
    for (int axis = 0; axis < 2; ++axis)
        std::copy(state[form.bead_velocity + axis].begin(), state[form.bead_velocity + axis].end(),
                  to.velocity[axis].begin());
}

measure::FieldMoment moment_of(const measure::FieldSetting& setting, const numerics::Spectra& state,
                               const FieldsOnGrid& on_grid) {
    return {.setting = setting,
            .spectra = state,
            .fields = on_grid.fields,
            .velocity = on_grid.velocity.size > 0 ? &on_grid.velocity : nullptr,
            .slaved_velocity = &on_grid.slaved};
}

}  // namespace drover::run
