// physics/predictions.hpp: linear theory about the state that a run is in.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "drover/physics/fluctuations.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

/// The stationary state closest to samples of the mean order: as a vector where a field fixes the direction, else by
/// its size.  nullptr without states.
const StationaryState* nearest_state(const StationaryStates& found, const std::vector<Eigen::Vector2d>& orders);

struct PredictedStructure {
    std::vector<StructureFactor> modes;  ///< of each stored mode of the grid; empty where there is no prediction
    std::string no_prediction;           ///< the reason for it
    std::string about;                   ///< the uniform state, for people
    bool about_flock = false;            ///< that state has order
};

/// Structure factors of a run whose mean order was `orders`; about a flock, averaged over the directions that the order
/// has taken.
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
