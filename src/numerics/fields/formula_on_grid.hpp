// numerics/fields/formula_on_grid.hpp: what a grid does to a formula in x, y, lx and ly (slots 0 to 3).
#pragma once
#include "drover/base/expression.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// The formula at the points of a grid, shifted by a displacement [mm]; one field.
Fields values_on(const Expression& formula, const Grid& grid, double shift_x = 0.0, double shift_y = 0.0);

/// The fraction of the variance of a formula that a grid cuts or aliases: the mean square difference from its kept
/// modes, between the points.  0 for a constant.  NaN if the formula is not finite everywhere.
double fraction_cut(const Expression& formula, const Grid& grid, int degree);

/// The smallest of up to 64 times as many points on one axis or both that cut less than `max_cut`; the grid itself if
/// none does.
Grid grid_that_resolves(const Expression& formula, const Grid& grid, int degree, double max_cut);

/// The values of a formula in the cells; returns the first cell where the value is not finite, or their number.
std::size_t fill_cells(const Expression& formula, const Grid& grid, Threads& threads, std::span<double> values);

/// The largest jump of a formula across a periodic edge.
struct EdgeJump {
    double size = 0.0;   ///< in the unit of the field
    double range = 0.0;  ///< of the field in the cell
    char axis = 'x';     ///< the axis that crosses the edge
    double at = 0.0;     ///< the other coordinate [mm]
};
EdgeJump edge_jump(const Expression& formula, const Grid& grid);

}  // namespace drover::numerics
