// dem/bodies/walls.hpp: the vertical side walls of a cell.
#pragma once
#include <array>
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::dem {

/// The nearest point of a wall.
struct WallPoint {
    double distance = 0.0;      ///< to the wall [mm]; < 0 outside the cell
    double nx = 0.0, ny = 0.0;  ///< of length 1, from the wall into the cell
};

/// The outline of a flower: each petal, in the frame of its middle line, is an arc over a chord between two inner
/// corners.
struct Flower {
    double half_turn = 0.0;           ///< pi/petals, between the middle line and a corner [rad]
    double half_chord = 0.0;          ///< [mm]
    double chord_at = 0.0;            ///< distance of the chord from the origin [mm]
    double arc_radius = 0.0;          ///< [mm]
    double arc_at = 0.0;              ///< distance of the arc's centre from the origin [mm]; < 0 for flat petals
    double half_angle = 0.0;          ///< of the arc, seen from its centre [rad]
    double cosine = 1.0, sine = 0.0;  ///< of half_angle
    std::vector<std::array<double, 2>> middle;  ///< of each petal, the direction of its middle line
    std::vector<std::array<double, 2>> corner;  ///< after each petal [mm]
};

Flower make_flower(const Cell& cell);

class Walls {
public:
    explicit Walls(const Cell& cell);

    /// All walls that a sphere of this radius at (x, y) touches, nearest first; at most four: two walls of a corner, or
    /// an arc and the inner corner of a flower.  None in a periodic cell.  The middle of a flower's first petal is on
    /// the x axis.
    int near(double x, double y, double radius, WallPoint (&found)[4]) const;

private:
    Cell cell_;
    Flower flower_;  ///< if the cell is a flower
};

/// Half the sides of the rectangle about the origin that contains the cell [mm].  Circle and flower are centred on the
/// origin; periodic cells and rectangles range from -lx/2 to lx/2.
double half_width(const Cell& cell);
double half_height(const Cell& cell);

}  // namespace drover::dem
