// dem/walls.hpp: the side walls of one cell, for many questions.
#pragma once
#include "drover/dem/wall.hpp"
#include "flower.hpp"

namespace drover::dem {

/// Answers as walls_near() does, with what all places share found once.
class Walls {
public:
    explicit Walls(const Cell& cell);
    int near(double x, double y, double radius, WallPoint (&found)[4]) const;

private:
    enum class Shape { none, rectangle, circle, flower };
    Cell cell_;
    Shape shape_ = Shape::none;
    Flower flower_;  ///< of a flower alone
};

}  // namespace drover::dem
