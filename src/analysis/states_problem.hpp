// analysis/states_problem.hpp: what drover states needs of a kind of scene.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "run/result.hpp"
#include "run/travelling_start.hpp"

namespace drover::analysis {

/// The number of the model that --follow names.
struct FollowedNumber {
    std::string key;
    std::string unit = "1";
    double last = 0.0;
};

struct StatesProblem {
    numerics::TravellingFamily family;  ///< its parameter is the followed number, or nothing
    std::optional<FollowedNumber> followed = std::nullopt;
    numerics::Grid grid;  ///< one row of points
    int degree = 1;       ///< that decides which modes are kept
    run::TravellingGuess guess;
    files::Recording frames;
    /// What is told of a state beside its speed.  fields: on the points of the line.
    std::function<std::vector<run::Entry>(const numerics::TravellingState& at, const numerics::Fields& fields)> entries;
    /// Further fields of the frames, which follow from the others; empty: none.
    std::function<numerics::Fields(const numerics::TravellingState& at)> further = {};
};

/// follow: KEY=VALUE of --follow; "": nothing.  Throws an input Error for a key that is not a number of the model.
StatesProblem states_problem(const io::Scene& scene, const std::string& follow, Threads& threads);

}  // namespace drover::analysis
