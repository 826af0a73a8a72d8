// run/fields/travelling_start.hpp: from the initial fields of a scene to a travelling state.
#pragma once
#include <functional>
#include <optional>

#include "io/scene.hpp"
#include "numerics/solvers/travelling_state.hpp"

namespace drover::run {

/// The scene on one row of points, without noise.
io::Scene line_of(const io::Scene& scene);

/// A guess evolves for some time [s], which brings it nearer to a stable state.
using Settle = std::function<void(double duration, numerics::Spectra& state)>;

/// How a state is looked for.
struct TravellingGuess {
    numerics::Spectra fields;
    Settle settle;
    double longest = 0.0;                        ///< to settle [s]
    std::optional<double> speed = std::nullopt;  ///< [mm/s]; nothing: from the guess of the state
    /// Time for which the guess evolves first [s]; nothing: 0 or, if no state is found, up to `longest`.
    std::optional<double> time = std::nullopt;
};

/// The initial fields of a scene of fields, averaged over y.  `line`: line_of(scene), which they settle by.
TravellingGuess travelling_guess(const io::Scene& scene, const io::Scene& line, Threads& threads);

/// Throws as the solver.
numerics::TravellingState find_state(const TravellingGuess& from, numerics::TravellingSolver& solver);

}  // namespace drover::run
