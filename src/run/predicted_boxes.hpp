// run/predicted_boxes.hpp: number fluctuations in boxes by linear theory.
#pragma once
#include <string>
#include <vector>

#include "drover/run/report.hpp"

namespace drover::run {

/// Adds the predictions of <what>_number_* from the structure factor of each stored mode.
void predict_boxes(const std::string& what, const std::vector<double>& structure_factor, Report& report);

}  // namespace drover::run
