// jobs/sweep_refinement.hpp: a grid that is finer where something changes.
#pragma once
#include <functional>
#include <vector>

namespace drover::jobs {

/// Ascending values along each axis.
using Axes = std::vector<std::vector<double>>;

/// Whether something differs between two points; the same either way.
using Differs = std::function<bool(const std::vector<double>& a, const std::vector<double>& b)>;

/// The points of a grid, and of finer ones: a cell with two points that differ, within it or on its border, is halved
/// along each axis, `levels` times at most.  Sorted.  Points that are not known yet differ from none: as more become
/// known more points are wanted, and in the end always the same ones, whatever the order.
std::vector<std::vector<double>> refined_points(const Axes& axes, int levels, const Differs& differs);

}  // namespace drover::jobs
