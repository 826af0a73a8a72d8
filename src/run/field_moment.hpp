// run/field_moment.hpp: a state of the fields on the grid, as the observables need it.
#pragma once
#include "drover/measure/fields.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/field_evolution.hpp"

namespace drover::run {

/// Its arrays keep their places from one state to the next: they may be lent out.
struct FieldsOnGrid {
    numerics::Fields fields;
    numerics::Fields slaved;     ///< the velocity of the beads, of a slaved form
    numerics::Spectra velocity;  ///< the same as modes, of every form that has one
};

/// Computes the state on the grid, and the velocity of the beads where the form has one.
void to_grid(const physics::FieldEvolution& evolution, numerics::Transform& transform, double time,
             const numerics::Spectra& state, FieldsOnGrid& to);

/// The moment of a state that to_grid() has computed; it refers to all of these.
measure::FieldMoment moment_of(const measure::FieldSetting& setting, const numerics::Spectra& state,
                               const FieldsOnGrid& on_grid);

}  // namespace drover::run
