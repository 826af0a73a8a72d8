// numerics/solvers/travelling_family.hpp: what a travelling state is a solution of.
#pragma once
#include <functional>

#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// A family of systems without noise on one line of points (grid.ny = 1).
struct TravellingFamily {
    std::function<System(double parameter)> system;
    /// The mean of a component that the family prescribes, where it is conserved; it moves with the parameter.
    std::function<double(double parameter, int component)> mean;
    double parameter = 0.0;  ///< of the state that find() looks for
};

/// A solution of  speed d_x a + L a + N(a) = 0  with the conserved means of the guess.
struct TravellingState {
    Spectra state;
    double speed = 0.0;  ///< along x [length/time]
    double parameter = 0.0;
    double speed_error = 0.0;  ///< of rounding and of the residual
    double residual = 0.0;     ///< the largest rate of a mode, relative to the rates of the linear terms
    int iterations = 0;        ///< of Newton's method
    double guessed_speed = 0.0;
    double change = 0.0;  ///< of the fields from their guess, in parts of the variation of the guess
};

}  // namespace drover::numerics
