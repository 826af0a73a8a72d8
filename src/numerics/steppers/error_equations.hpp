// numerics/steppers/error_equations.hpp: the equations of a run by which the error of its steps evolves.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// The equations of a run, as the estimate needs them.
struct ErrorEquations {
    struct Field {
        int first = 0, components = 1;  ///< in a state
        std::string name;
    };
    /// L and N on a grid, without noise; degree: which of its modes are kept, 1: all, whatever the products need.
    using OnGrid = std::function<System(const Grid& grid, int degree, Threads& threads)>;

    std::vector<Field> fields;
    OnGrid on_grid;
    int degree = 1;  ///< as System::degree of the run
    bool noisy = false;
    double shortest = 0.0;  ///< wavenumber [1/mm] up to which the error needs modes of its own: those that are unstable
    /// First components of vectors that noise turns together without limit, in the direction of the mean of the first:
    /// errors of that direction change no mean, and are left out.
    std::vector<int> turning = {};
};

}  // namespace drover::numerics
