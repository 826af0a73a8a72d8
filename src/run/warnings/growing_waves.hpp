// run/warnings/growing_waves.hpp: whether a grid keeps the waves that grow about the references of equations.
#pragma once
#include <string>

#include "drover/model/equations.hpp"

namespace drover::run {

// Of a system of the equations.  Where a term depends on position or time, or has no derivative at the references, its
// linear part stands for theirs.

/// The largest wavenumber up to `max_q` whose waves grow, in any direction; 0: none.  max_q: that of the grid.
double largest_growing(const model::Equations& equations, const numerics::System& system, double max_q);

/// The warning of a grid that cuts waves which grow, with a grid that keeps them; "" where it keeps them all.
std::string growing_waves_warning(const model::Equations& equations, const numerics::System& system);

/// "grid.nx = 64 and grid.ny = 32", or "grid.nx = 64" of a grid of one row; with `factor` times the points.
std::string grid_keys(const numerics::Grid& grid, int factor = 1);

}  // namespace drover::run
