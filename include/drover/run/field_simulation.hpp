// run/field_simulation.hpp: a scene of fields as a Simulation.
#pragma once
#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/measure/observables.hpp"
#include "drover/run/kind.hpp"

namespace drover::run {

// A scene of fields, for run/kind.hpp: what each is stands there.
int choose_threads(const io::Scene& scene);
double field_simulation_bytes(const io::Scene& scene);
double field_disk_bytes(const io::Scene& scene);
std::string field_size(const io::Scene& scene);
TimedScene timed_fields(const io::Scene& scene);

/// Throws an input Error for an initial file that is not of this grid and form.
Simulation make_field_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved = {});

/// The axes of observables, as files have them.
std::vector<files::Axis> observable_axes(const measure::Setting& setting);

}  // namespace drover::run
