// dem/bodies/walls.hpp: the side walls of one cell, for repeated searches.
#pragma once
#include "dem/bodies/flower.hpp"
#include "dem/bodies/wall.hpp"

namespace drover::dem {

/// The same results as walls_near(), with the geometry of the cell computed once.
class Walls {
public:
    explicit Walls(const Cell& cell);
    int near(double x, double y, double radius, WallPoint (&found)[4]) const;

private:
    enum class Shape { none, rectangle, circle, flower };
    Cell cell_;
    Shape shape_ = Shape::none;
    Flower flower_;  ///< if the cell is a flower
};

}  // namespace drover::dem
