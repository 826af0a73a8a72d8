// physics/slaved_velocity.cpp: the velocity of beads whose forces are in balance at every moment.
#include <Eigen/LU>

#include "body_force.hpp"
#include "drover/physics/right_hand_side.hpp"
#include "drover/physics/term.hpp"
#include "point_arrays.hpp"

namespace drover::physics {

using numerics::Spectra;
using numerics::Wavevector;

numerics::Fields slaved_velocity(const Equations& e, const numerics::System& linear, double t, const Spectra& state,
                                 const numerics::Transform& transform) {
    Spectra made(linear.grid, 2);
    const Reference ref = reference(e.model.uniform);
    const UniformPoint about{.bead_density = ref.bead_density, .rod_density = ref.rod_density};
    const std::size_t width = numerics::columns(linear.grid);
    const Form& form = e.form;
    for (std::size_t m = 0; m < state.size; ++m) {
        if (!numerics::is_kept(linear.grid, linear.degree, m % width, m / width)) continue;
        const Wavevector q = numerics::wavevector(linear.grid, m % width, m / width);
        const Symbol symbol = force_symbol(e, about, q);
        Eigen::Vector2cd force = Eigen::Vector2cd::Zero();
        if (form.bead_density >= 0)
            force +=
                symbol.block<2, 1>(FieldIndex::bead_velocity_x, FieldIndex::bead_density) * state[form.bead_density][m];
        if (form.rod_density >= 0)
            force +=
                symbol.block<2, 1>(FieldIndex::bead_velocity_x, FieldIndex::rod_density) * state[form.rod_density][m];
        force += symbol.block<2, 2>(FieldIndex::bead_velocity_x, FieldIndex::polar_order_x) *
                 Eigen::Vector2cd(state[form.polar_order][m], state[form.polar_order + 1][m]);
        if (has_term(e, "force")) {
            const ForceMode outside = force_mode(e.model.force, linear.grid, t, q);
            force += Eigen::Vector2cd(outside.x, outside.y);
        }
        const Eigen::Vector2cd velocity =
            -symbol.block<2, 2>(FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x).inverse() * force;
        made[0][m] = velocity.x();
        made[1][m] = velocity.y();
    }
    numerics::Fields result(linear.grid, 2);
    transform.backward(made, result);
    if (!slaved_varies(e)) return result;
    numerics::Fields fields(linear.grid, state.count());
    transform.backward(state, fields);
    const double drag_ref = e.drag.at(ref.bead_density, ref.rod_density).value,
                 driving_ref = e.driving.at(ref.bead_density, ref.rod_density).value;
    for (std::size_t i = 0; i < fields.size; ++i) {
        const double beads = form.bead_density >= 0 ? fields[form.bead_density][i] : ref.bead_density,
                     rods = form.rod_density >= 0 ? fields[form.rod_density][i] : ref.rod_density;
        const double gamma = e.drag.at(beads, rods).value, driven = e.driving.at(beads, rods).value - driving_ref;
        for (int axis = 0; axis < 2; ++axis)
            result[axis][i] = (drag_ref * result[axis][i] + driven * fields[form.polar_order + axis][i]) / gamma;
    }
    return result;
}

}  // namespace drover::physics
