// run/model_stability.hpp: the uniform states of a declared model and their waves.
#pragma once
#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// make_stability() for a scene with a model of its own.
Result make_model_stability(const io::Scene& scene, double min_wavenumber, double max_wavenumber, Threads* threads);

/// "phi = 0.3, |p| = 0.5": the values of a state for people, fields of value 0 left out.
std::string state_text(const model::Model& model, const model::UniformState& values);

}  // namespace drover::run
