// dem/bodies/flower.hpp: geometry of the outline of a flower.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::dem {

/// Each petal, in the frame of its middle line, is an arc over a chord between two inner corners.
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

inline Flower make_flower(const Cell& cell) {
    Flower flower{.half_turn = std::numbers::pi / cell.petals, .arc_radius = cell.petal_radius};
    flower.half_chord = cell.radius * std::sin(flower.half_turn);
    flower.chord_at = cell.radius * std::cos(flower.half_turn);
    const double square = cell.petal_radius * cell.petal_radius - flower.half_chord * flower.half_chord;
    flower.arc_at = flower.chord_at - std::sqrt(std::max(0.0, square));
    flower.half_angle = std::asin(std::min(1.0, flower.half_chord / cell.petal_radius));
    flower.cosine = std::cos(flower.half_angle);
    flower.sine = std::sin(flower.half_angle);
    for (int k = 0; k < cell.petals; ++k) {
        const double middle = 2.0 * flower.half_turn * k, corner = middle + flower.half_turn;
        flower.middle.push_back({std::cos(middle), std::sin(middle)});
        flower.corner.push_back({cell.radius * std::cos(corner), cell.radius * std::sin(corner)});
    }
    return flower;
}

}  // namespace drover::dem
