// dem/wall.hpp: the side walls of a cell, which stand upright on the plates.
#pragma once
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::dem {

/// The wall near a place in the plane.
struct WallPoint {
    double distance = 0.0;      ///< from the place to the wall [mm]; < 0 outside
    double nx = 0.0, ny = 0.0;  ///< of length 1, from the wall into the cell
};

/// All that is near enough for a sphere of this radius at (x, y) to touch it, at most four: two walls of a corner, an arc and the
/// inner corner of a flower.  The nearest first; none in a periodic cell.  The middle of a flower's first petal points along x.
int walls_near(const Cell& cell, double x, double y, double radius, WallPoint (&found)[4]);

/// Half the sides of the rectangle about the origin that holds the cell [mm].  Circle and flower are centred on the origin; periodic cells and
/// rectangles go from -lx/2 to lx/2.
double half_width(const Cell& cell);
double half_height(const Cell& cell);

}  // namespace drover::dem
