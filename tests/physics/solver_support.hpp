// tests/physics/solver_support.hpp: runs of the solver on small grids.
#pragma once
#include <algorithm>
#include <cmath>
#include <string>

#include "drover/numerics/stepper.hpp"
#include "full_model.hpp"
#include "initial_spectra.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics {

/// Nothing from outside: beads at rest without order are in balance.
inline Model undisturbed(Model model) {
    model.force.kind = "none";
    model.orienting_field = {};
    return model;
}

/// Waves of one amplitude in every field about the uniform state, long beside the grid.
inline numerics::Spectra waves(const Form& form, const UniformState& uniform, const numerics::Grid& grid,
                               double amplitude) {
    numerics::Spectra state(grid, numerics::components(layout(form)));
    const std::size_t width = numerics::columns(grid);
    for (int c = 0; c < state.count(); ++c) {
        state[c][width + 1] = 0.25 * amplitude * std::polar(1.0, 0.7 * c);  // mode (1, 1)
        state[c][1] = 0.25 * amplitude * std::polar(1.0, 0.4 - 0.9 * c);    // mode (1, 0)
    }
    if (form.bead_density >= 0) state[form.bead_density][0] = uniform.bead_density;
    if (form.rod_density >= 0) state[form.rod_density][0] = uniform.rod_density;
    return state;
}

inline numerics::Spectra evolved(const numerics::System& system, const std::string& method, double dt, int steps,
                                 numerics::Spectra state) {
    Threads threads(1);
    numerics::Stepper stepper(system, numerics::stepper_table(method), dt, 1, threads);
    for (int i = 0; i < steps; ++i) stepper.step(i * dt, static_cast<std::uint64_t>(i), state);
    return state;
}

/// Largest difference of any mode.
inline double distance(const numerics::Spectra& a, const numerics::Spectra& b) {
    double largest = 0.0;
    for (std::size_t m = 0; m < a.values.size(); ++m) largest = std::max(largest, std::abs(a.values[m] - b.values[m]));
    return largest;
}

}  // namespace drover::physics
