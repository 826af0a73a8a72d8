// report/explain_particles.hpp: what a scene of particles holds.
#pragma once
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::report {

/// The bodies in their cell, its plates, and the measurements of a calibration.
run::Record explain_particles(const io::Scene& scene);

}  // namespace drover::report
