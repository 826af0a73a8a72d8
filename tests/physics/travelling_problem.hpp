// tests/physics/travelling_problem.hpp: travelling states of rods and beads.
#pragma once
#include <functional>

#include "numerics/solvers/travelling_state.hpp"
#include "physics/integrated.hpp"
#include "theory/binodal.hpp"

namespace drover::physics {

using numerics::TravellingState;

/// A family of models on one line of points (grid.ny = 1); their noise is left out.
struct TravellingProblem {
    std::function<ModelValues(double parameter)> model;
    double parameter = 0.0;  ///< of the state that find() looks for
    numerics::Grid grid;
    numerics::Dealiasing dealiasing;
};

inline theory::TravellingProblem of_model(const TravellingProblem& problem) {
    return {.at = [problem](double parameter) { return integrated(problem.model(parameter), problem.dealiasing); },
            .parameter = problem.parameter,
            .grid = problem.grid};
}

inline numerics::TravellingFamily travelling_family(const TravellingProblem& problem, Threads& threads) {
    return theory::travelling_family(of_model(problem), threads);
}

struct TravellingSolver : numerics::TravellingSolver {
    TravellingSolver(const TravellingProblem& problem, Threads& threads)
        : numerics::TravellingSolver(travelling_family(problem, threads)) {}
};

}  // namespace drover::physics
