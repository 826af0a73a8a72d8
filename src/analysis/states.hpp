// analysis/states.hpp: the travelling and standing states of a scene, as a result.
#pragma once
#include <optional>
#include <string>

#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "numerics/solvers/travelling_state.hpp"
#include "run/result.hpp"

namespace drover::analysis {

struct StatesOptions {
    std::optional<double> speed = std::nullopt;  ///< its guess [mm/s]; nothing: from the guess of the state
    /// Time for which the guess evolves first [s]; nothing: 0 or, if no state is found, up to time.end.
    std::optional<double> settle = std::nullopt;
    std::string follow = {};  ///< "relaxation.rate = 1.2": the curve of states through this one
    int max_points = 60;      ///< of the curve
};

/// The state along x next to the initial fields of a scene on a grid, averaged over y, without noise: speed, densities
/// (of a model of its own: mean, extremes and plateaus of each field), perturbations that depend on x; with `follow`
/// the curve of states.  Archives hold the fields as frames, which initial.kind = "file" accepts.  Throws an input
/// Error for a key that is not a number of the model, and as numerics::TravellingSolver.
run::Result make_states(const io::Scene& scene, const StatesOptions& options, Threads& threads);

/// The largest part of the variance of a component of a state that is in the shortest waves of a grid that keeps the
/// modes of products of this degree.
double tail_of(const numerics::TravellingState& state, const numerics::Grid& grid, int degree);

}  // namespace drover::analysis
