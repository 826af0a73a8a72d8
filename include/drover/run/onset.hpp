// run/onset.hpp: the flocking thresholds of a table of coefficients as a result.
#pragma once
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "drover/calibrate/field_model.hpp"
#include "drover/calibrate/onset.hpp"
#include "drover/io/scene.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// Curves, over rod and bead area fraction; crossings in both conventions of lambda; and the line through them.
Result onset_result(const calibrate::Onset& onset, const calibrate::Table& table);

/// Adds the order of the rods of one cell at these points.
void add_cells(const std::vector<std::pair<calibrate::StatePoint, calibrate::CellPrediction>>& cells, Result& result);

struct TableOnset {
    io::Scene scene;  ///< of the calibration
    calibrate::Table table;
    std::size_t varied = 0;  ///< index of that value
    Result result;
};
/// Of a file of coefficients, for the value `varied` of the key that it varies.  Throws an input Error for another
/// file, and as calibrate::varied_index.
TableOnset make_onset(const std::filesystem::path& file, const std::optional<double>& varied);

}  // namespace drover::run
