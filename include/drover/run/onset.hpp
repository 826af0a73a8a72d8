// run/onset.hpp: the flocking thresholds of a table of coefficients as a result.
#pragma once
#include <utility>
#include <vector>

#include "drover/calibrate/field_model.hpp"
#include "drover/calibrate/onset.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// Curves, over rod and bead area fraction; crossings in both conventions of lambda; and the line through them.
Result onset_result(const calibrate::Onset& onset, const calibrate::Table& table);

/// Adds the order of the rods of one cell at these points.
void add_cells(const std::vector<std::pair<calibrate::StatePoint, calibrate::CellPrediction>>& cells, Result& result);

}  // namespace drover::run
