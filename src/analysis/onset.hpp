// analysis/onset.hpp: the flocking thresholds of a table of coefficients as a result.
#pragma once
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "calibrate/onset.hpp"
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::analysis {

struct TableOnset {
    io::Scene scene;  ///< of the calibration
    calibrate::Table table;
    std::size_t varied = 0;  ///< index of that value
    run::Result result;
};
/// Of a file of coefficients, for the value `varied` of the key that it varies, with errors from so many draws.  Throws
/// an input Error for another file, and as calibrate::varied_index.
TableOnset make_onset(const std::filesystem::path& file, const std::optional<double>& varied,
                      int draws = calibrate::error_draws);

/// Area fractions of beads and of rods.
using AreaFractions = std::pair<double, double>;

/// Adds the order of the rods of a square cell of this side [mm] to the result, at these points or, without any, at
/// the nodes of the table.  Throws an input Error for a side or an area fraction that is not above 0.
void add_cells(TableOnset& onset, double side, const std::vector<AreaFractions>& points);

}  // namespace drover::analysis
