// run/model_stability.hpp: the uniform states of a declared model and their waves.
#pragma once
#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/model/theory.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// make_stability() for a scene with a model of its own.
Result make_model_stability(const io::Scene& scene, Threads* threads);

/// The waves that a scene searches: by default from a thousandth of the smallest |q| of its cell to the largest of its
/// grid.  Throws an input Error for an empty range.
model::GrowthSearch growth_search(const io::Scene& scene);

/// A row of a list of slow modes; direction: from which angles [degrees] are measured.
Record slow_mode_record(const model::SlowMode& mode, double angle, const std::string& direction, bool is_in_text);

/// "phi = 0.3, |p| = 0.5": the values of a state for people, fields of value 0 left out.
std::string state_text(const model::Model& model, const model::UniformState& values);

/// "ordered, phi = 0.3, |p| = 0.5".
std::string state_words(const model::Model& model, const model::StationaryState& state);

}  // namespace drover::run
