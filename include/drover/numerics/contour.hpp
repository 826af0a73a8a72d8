// numerics/contour.hpp: the lines of the plane on which a function changes sign.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "drover/base/threads.hpp"

namespace drover::numerics {

struct Rectangle {
    double x0 = 0.0, x1 = 1.0;
    double y0 = 0.0, y1 = 1.0;
};

struct PlanePoint {
    double x = 0.0, y = 0.0;
};

/// Only its sign is promised a meaning, zero being positive; a smooth one is traced with fewer evaluations.  It may
/// jump and be infinite; not-a-number: not defined there.  Called only inside the rectangle, by several threads at once.
using PlaneFunction = std::function<double(const PlanePoint&)>;

/// How fine a line is traced.  Lengths are those of the unit square on which the rectangle is laid.
struct ContourOptions {
    /// 1 to 2048 sampling cells on each side.  An island of either sign is found for certain when it holds a disc of
    /// diameter above 1/cells: the corners and centres of the cells leave no larger disc empty.
    int cells = 64;
    double chord = 1e-4;          ///< largest distance between the line and its polyline
    double finest = 1e-8;         ///< shortest edge of the mesh, >= 4e-9: reached at cusps, double points and corners
    double root = 1e-12;          ///< error of a vertex along the mesh edge that the line crosses; 1e-15 to finest/100
    double verge = 1.0 / 1024.0;  ///< >= 2 finest: a line ends no farther than this from where f is not defined
    double noise = 0.0;           ///< error of f, >= 0: the mesh is not refined where |f| is no_location above 3 noise
    std::size_t evaluations = 1'000'000;  ///< beyond these the mesh is not refined: see Contour::complete
};

/// At least two points, each on the line within ContourOptions::root, the positive side to the left (of axes x to the
/// right, y up).  An open line ends on the border of the rectangle or where the function ceases to be defined.
struct ContourLine {
    std::vector<PlanePoint> points;
    bool closed = false;  ///< the first point is not repeated
};

struct Contour {
    std::vector<ContourLine> lines;
    /// Where the finest mesh did not straighten the line, and islands less than 100 ContourOptions::finest across, which
    /// are not among the lines.  One point stands for all within a chord.
    std::vector<PlanePoint> sharp;
    std::size_t evaluations = 0;  ///< of the function
    bool complete = true;         ///< false: stopped by ContourOptions::evaluations; `chord` holds only part of the way
};

/// Traces the lines on which f changes sign.  Not seen: lines on which it is zero without a change of sign, and of the
/// islands too small to be found for certain those between the samples (beside a line, also the middles of the edges of
/// the mesh).  Two lines closer to each other than a cell are
/// told apart wherever a sample falls between them, and from there on along both, but where they are closer than
/// ContourOptions::finest they may break.  The same for any number of threads.
/// Throws an input Error for a rectangle that is empty or not finite and for options out of range.
Contour trace_zero(const PlaneFunction& f, const Rectangle& where, const ContourOptions& options, Threads& threads);

}  // namespace drover::numerics
