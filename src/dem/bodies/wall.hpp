// dem/bodies/wall.hpp: the vertical side walls of a cell.
#pragma once
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::dem {

/// The nearest point of a wall.
struct WallPoint {
    double distance = 0.0;      ///< to the wall [mm]; < 0 outside the cell
    double nx = 0.0, ny = 0.0;  ///< of length 1, from the wall into the cell
};

/// All walls that a sphere of this radius at (x, y) touches, nearest first; at most four: two walls of a corner, or an
/// arc and the inner corner of a flower.  None in a periodic cell.  The middle of a flower's first petal is on the x
/// axis.
int walls_near(const Cell& cell, double x, double y, double radius, WallPoint (&found)[4]);

/// Half the sides of the rectangle about the origin that contains the cell [mm].  Circle and flower are centred on the
/// origin; periodic cells and rectangles range from -lx/2 to lx/2.
double half_width(const Cell& cell);
double half_height(const Cell& cell);

}  // namespace drover::dem
