// report/explain_particles.hpp: what a scene of particles holds.
#pragma once
#include "drover/io/scene.hpp"
#include "drover/run/result.hpp"

namespace drover::report {

/// The bodies in their cell, its plates, and the measurements of a calibration.
run::Record explain_particles(const io::Scene& scene);

}  // namespace drover::report
