// theory/travelling_family.hpp: states of a model that travel along x, as a number of it changes.
#pragma once
#include <functional>

#include "model/field_evolution.hpp"
#include "numerics/solvers/travelling_family.hpp"

namespace drover::theory {

/// A family of models on one line of points (grid.ny = 1); their noise is left out.
struct TravellingProblem {
    std::function<model::Integrated(double parameter)> at;  ///< what is integrated at a value of the parameter
    double parameter = 0.0;                                 ///< of the state that is looked for
    numerics::Grid grid;
};

/// What is integrated at the last value of the parameter is kept.  Its systems throw an input Error for a term that
/// depends on position or time.
numerics::TravellingFamily travelling_family(const TravellingProblem& problem, Threads& threads);

}  // namespace drover::theory
