// run/travelling_start.hpp: the travelling state next to the initial fields of a scene.
#pragma once
#include <optional>

#include "drover/io/scene.hpp"
#include "drover/physics/travelling_problem.hpp"

namespace drover::run {

/// The scene on one row of points, without noise.
io::Scene line_of(const io::Scene& scene);

/// How a state is looked for.
struct TravellingGuess {
    std::optional<double> speed = std::nullopt;  ///< [mm/s]; nothing: from the guess of the state
    /// Time for which the guess evolves first [s]; nothing: 0 or, if no state is found, up to time.end.
    std::optional<double> settle = std::nullopt;
};

/// From the initial fields, averaged over y.  `line`: line_of(scene), for whose model the solver looks.
physics::TravellingState find_state(const io::Scene& scene, const io::Scene& line, const TravellingGuess& from,
                                    physics::TravellingSolver& solver, Threads& threads);

}  // namespace drover::run
