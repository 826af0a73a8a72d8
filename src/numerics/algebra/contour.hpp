// numerics/algebra/contour.hpp: the lines on which a function of the plane changes sign.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "base/compute_all.hpp"

namespace drover::numerics {

struct Rectangle {
    double x0 = 0.0, x1 = 1.0;
    double y0 = 0.0, y1 = 1.0;
};

struct PlanePoint {
    double x = 0.0, y = 0.0;
};

/// Only its sign matters, and zero counts as positive; smooth functions need fewer evaluations.  It may jump and be
/// infinite; NaN: not defined there.  Called only inside the rectangle, by several threads at once.
using PlaneFunction = std::function<double(const PlanePoint&)>;

/// Resolution of the lines.  Lengths refer to the rectangle scaled to the unit square.
struct ContourOptions {
    /// 1 to 2048 sampling cells on each side.  Every island of either sign that contains a disc of diameter above
    /// 1/cells is found: the corners and centres of the cells leave no larger disc empty.
    int cells = 64;
    double chord = 1e-4;                  ///< largest distance between the line and its polyline
    std::size_t evaluations = 1'000'000;  ///< limit; no refinement beyond it, see Contour::complete
};
/// Edges of the mesh are as short as this at cusps, double points and corners.
inline constexpr double finest_edge = 1e-8;

/// At least two points, each on the line within rounding, the positive side to the left (of axes x to the right, y up).
/// An open line ends on the border of the rectangle, or no farther than 1/1024 from where the function ceases to be
/// defined.
struct ContourLine {
    std::vector<PlanePoint> points;
    bool closed = false;  ///< the first point is not repeated
};

struct Contour {
    std::vector<ContourLine> lines;
    /// Where the line is not straight on the finest mesh, and islands less than 100 finest_edge across,
    /// which are not among the lines.  One point represents all within a chord.
    std::vector<PlanePoint> singular_points;
    double positive = 0.0, negative = 0.0;  ///< fractions of the first samples, at the corners and centres of the cells
    std::size_t evaluations = 0;            ///< of the function
    bool complete =
        true;  ///< false: stopped by ContourOptions::evaluations; parts of the lines are coarser than `chord`
};

/// Traces the lines on which f changes sign.  Not found: lines on which it is zero without a change of sign, and small
/// islands between the samples (beside a line also between the middles of the mesh edges).  Two lines closer to each
/// other than a cell are separated where a sample falls between them, and from there on along both; where they are
/// closer than finest_edge they may break.  The result does not depend on who computes.
/// Throws an input Error for a rectangle that is empty or not finite and for options out of range.
Contour trace_zero(const PlaneFunction& f, const Rectangle& where, const ContourOptions& options,
                   const ComputeAll& compute);

}  // namespace drover::numerics
