// run/field_simulation.hpp: a scene of fields as a Simulation.
#pragma once
#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/measure/observables.hpp"
#include "drover/run/simulation.hpp"

namespace drover::run {

/// Threads for a scene: as asked, or the cores that the process may use, fewer where a grid cannot feed them.
int choose_threads(const io::Scene& scene);

/// Memory that the simulation will hold [bytes].
double field_simulation_bytes(const io::Scene& scene);

/// The scene's world in its initial state.  `threads` must outlive it.  Throws an input Error for an initial file that is not of
/// this grid and form.
Simulation make_field_simulation(const io::Scene& scene, Threads& threads);

/// The axes of observables, as files have them, and the names of those that one observable has.
std::vector<io::Axis> observable_axes(const measure::Setting& setting);
std::vector<std::string> axis_names(std::span<const measure::ObservableAxis> axes);

}  // namespace drover::run
