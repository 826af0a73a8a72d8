// run/model_simulation.hpp: a scene with a model of its own as a Simulation.
#pragma once
#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/model/equations.hpp"
#include "drover/run/report.hpp"
#include "drover/run/scene_support.hpp"
#include "drover/run/simulation.hpp"

namespace drover::run {

// The functions of declared models for run/kind.hpp, which documents them.
double model_simulation_bytes(const io::Scene& scene);
double model_disk_bytes(const io::Scene& scene);
std::vector<std::string> model_warnings(const io::Scene& scene);
Report make_model_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory);

/// Throws an input Error for an initial file with another cell or other fields.
Simulation make_model_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved = {});

/// The fields at t = 0.  Throws as make_model_simulation().
numerics::Spectra initial_model_fields(const io::Scene& scene, Threads& threads);

/// The frames of a run.
files::Recording model_frame_recording(const io::Scene& scene, const model::Equations& equations);

}  // namespace drover::run
