// tests/measure/fields_support.hpp: fields of rods and beads, and a moment of them, for tests.
#pragma once
#include <string>

#include "measure/fields.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::measure {

/// kind: of the current; "order": p is a density.
inline physics::Model model_of(const physics::FieldChoice& fields, const std::string& kind) {
    physics::Model model{.fields = fields};
    model.current.kind = kind;
    if (fields.bead_velocity != "absent") model.drag.coefficient = 1.0;
    return model;
}

inline FieldSetting setting_of(const numerics::Grid& grid, const physics::Model& model, int degree = 1) {
    return make_field_setting(physics::Equations(model).solver(physics::mean_densities(model)), grid, degree);
}
inline FieldSetting rods_on(const numerics::Grid& grid, int degree = 1) {
    return setting_of(grid, model_of({}, "order"), degree);
}

/// Without fields in balance.
inline FieldMoment moment_of(const FieldSetting& setting, const numerics::Spectra& state,
                             const numerics::Fields& fields) {
    static const numerics::Spectra no_modes;
    static const numerics::Fields no_points;
    return {.setting = setting,
            .state = state,
            .state_on_grid = fields,
            .balanced = no_modes,
            .balanced_on_grid = no_points};
}

}  // namespace drover::measure
