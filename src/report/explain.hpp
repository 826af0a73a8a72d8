// report/explain.hpp: what a scene holds and what it costs.
#pragma once
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::report {

/// Fields, the terms of their equations, coefficients, kept modes and the growth about the references, or bodies;
/// memory, disk and wall time, for which a few steps are timed.  Of a scene with a time step.
run::Result explain(const io::Scene& scene);

/// Its part for particles: the bodies in their cell, its plates, and the measurements of a calibration.
run::Record explain_particles(const io::Scene& scene);

}  // namespace drover::report
