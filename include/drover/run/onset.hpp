// run/onset.hpp: the flocking thresholds of a table of coefficients as a result.
#pragma once
#include "drover/calibrate/onset.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// Curves, over rod and bead area fraction; crossings in both conventions of lambda; and the line through them.
Result onset_result(const calibrate::Onset& onset, const calibrate::Table& table);

}  // namespace drover::run
