// theory/refined_wave.hpp: from the best place of a search to the fastest wave.
#pragma once
#include <utility>
#include <vector>

#include "drover/theory/theory.hpp"

namespace drover::theory {

/// The wave of the maximum next to a place, as log |q| and angle, or the uniform state where that grows faster.
/// log_q: the places of the search; step_angle: between its angles, 0 where all directions are equivalent.
FastestWave refined_wave(const model::LinearisedAt& at, const GrowthSearch& search, const std::vector<double>& log_q,
                         std::pair<double, double> place, double step_angle);

}  // namespace drover::theory
