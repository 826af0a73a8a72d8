// physics/travelling_problem.hpp: what a travelling state is a solution of.
#pragma once
#include <functional>

#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

/// A family of models on one line of points (grid.ny = 1).
struct TravellingProblem {
    std::function<Model(double parameter)> model;
    double parameter = 0.0;  ///< of the state that find() looks for
    numerics::Grid grid;
    Dealiasing dealiasing;
};

/// A solution of  speed d_x a + L a + N(a) = 0  with the mean densities of the guess.
struct TravellingState {
    numerics::Spectra state;
    double speed = 0.0;  ///< along x [mm/s]
    double parameter = 0.0;
    double speed_error = 0.0;  ///< mm/s, of rounding and of the residual
    double residual = 0.0;     ///< the largest rate of a mode, relative to the rates of the linear terms
    int iterations = 0;        ///< of Newton's method
};

}  // namespace drover::physics
