// run/model_explain.hpp: what a scene with a model of its own holds and costs.
#pragma once
#include "drover/io/scene.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// Fields, equations by terms, coefficients, transforms, kept modes, memory, disk and wall time.
Result explain_model(const io::Scene& scene);

}  // namespace drover::run
