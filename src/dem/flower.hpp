// dem/flower.hpp: the lengths of a flower's outline.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/dem/setup.hpp"

namespace drover::dem {

/// One petal, seen along its own middle line: an arc over a chord between two inner corners.
struct Flower {
    double half_turn = 0.0;   ///< pi/petals, between the middle line and a corner [rad]
    double half_chord = 0.0;  ///< [mm]
    double chord_at = 0.0;    ///< of the chord from the origin [mm]
    double arc_radius = 0.0;  ///< [mm]
    double arc_at = 0.0;      ///< of the arc's centre from the origin [mm]; < 0 where petals are flatter than a circle
    double half_angle = 0.0;  ///< of the arc, seen from its centre [rad]
};

inline Flower make_flower(const Cell& cell) {
    Flower flower{.half_turn = std::numbers::pi / cell.petals, .arc_radius = cell.petal_radius};
    flower.half_chord = cell.radius * std::sin(flower.half_turn);
    flower.chord_at = cell.radius * std::cos(flower.half_turn);
    const double square = cell.petal_radius * cell.petal_radius - flower.half_chord * flower.half_chord;
    flower.arc_at = flower.chord_at - std::sqrt(std::max(0.0, square));
    flower.half_angle = std::asin(std::min(1.0, flower.half_chord / cell.petal_radius));
    return flower;
}

}  // namespace drover::dem
