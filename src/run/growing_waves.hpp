// run/growing_waves.hpp: whether a grid keeps the waves that grow by the linear part of a system.
#pragma once
#include <string>

#include "drover/numerics/system.hpp"

namespace drover::run {

/// The largest wavenumber up to `max_q` of a linear part whose waves grow; 0: none.  max_q: that of the grid.
double largest_growing(const numerics::System& system, double max_q);

/// The warning of a grid that cuts waves which grow, with a grid that keeps them; "" where it keeps them all.
std::string growing_waves_warning(const numerics::System& system);

/// "grid.nx = 64 and grid.ny = 32", or "grid.nx = 64" of a grid of one row; with `factor` times the points.
std::string grid_keys(const numerics::Grid& grid, int factor = 1);

}  // namespace drover::run
