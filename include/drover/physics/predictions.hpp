// physics/predictions.hpp: linear theory about the present state of a run.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "drover/physics/fluctuations.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

/// The stationary state closest to samples of the mean order: compared as vectors if a field fixes the direction, else
/// by magnitude.  nullptr if there are no states.
const StationaryState* nearest_state(const StationaryStates& found, const std::vector<Eigen::Vector2d>& orders);

struct PredictedStructure {
    std::vector<StructureFactor> modes;  ///< for each stored mode of the grid; empty without a prediction
    std::string no_prediction;           ///< why there is no prediction
    std::string about;                   ///< description of the uniform state
    bool about_flock = false;            ///< the uniform state has order
};

/// Structure factors of a run with samples `orders` of the mean order; about a flock they are averaged over the
/// directions of these samples.
PredictedStructure predicted_structure(const Equations& equations, const numerics::Grid& grid,
                                       const Dealiasing& dealiasing, const std::vector<Eigen::Vector2d>& orders,
                                       Threads& threads);

/// Number fluctuations in boxes of `sides` cells times (along_x, along_y).
struct PredictedBoxes {
    std::vector<double> variance, deviation;
    std::vector<double> exponent;  ///< d log deviation/d log area between one box and the next; NaN at the last
};
PredictedBoxes predicted_boxes(const numerics::Grid& grid, const std::vector<double>& structure_factor,
                               const std::vector<int>& sides, int along_x, int along_y);

}  // namespace drover::physics
