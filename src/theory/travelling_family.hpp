// theory/travelling_family.hpp: states of a model that travel along x, as a number of it changes.
#pragma once
#include <functional>

#include "model/field_evolution.hpp"
#include "numerics/solvers/travelling_family.hpp"

namespace drover::theory {

/// Without noise, on one row of points.  at: what is integrated at a value of the parameter; the last is kept.  Its
/// systems throw an input Error for a term that depends on position or time.
numerics::TravellingFamily travelling_family(std::function<model::Integrated(double parameter)> at, double parameter,
                                             const numerics::Grid& line, Threads& threads);

}  // namespace drover::theory
