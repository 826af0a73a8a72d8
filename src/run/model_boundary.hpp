// run/model_boundary.hpp: where the uniform states of a declared model become unstable, in a plane of its coefficients.
#pragma once
#include "drover/io/scene.hpp"
#include "drover/run/boundary_work.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// make_boundary() for a scene with a model of its own.
Result make_model_boundary(const io::Scene& scene, Threads& threads, const BoundaryWork& work);

/// Throws the input Errors of make_model_boundary without tracing.
void check_model_boundary(const io::Scene& scene);

}  // namespace drover::run
