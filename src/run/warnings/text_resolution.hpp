// run/warnings/text_resolution.hpp: whether the grid and the time step resolve texts of x, y and t.
#pragma once
#include <string>
#include <vector>

#include "drover/model/model.hpp"
#include "io/scene.hpp"

namespace drover::run {

/// model: of the equations of the scene, for both.

/// Whether the steps of a scene see its terms of t: they are compared with a finer sampling, also about each time that
/// the formulas name.  True where that is not known.
bool resolves_time(const io::Scene& scene, const model::Model& model);

/// Of the terms written as text.  Those of x and y are compared with their values on twice the grid, those of t with a
/// finer sampling of the time between steps, both at a smooth state; of a long run in windows of time.
std::vector<std::string> text_resolution_warnings(const io::Scene& scene, const model::Model& model);

}  // namespace drover::run
