// dem/packing/supply.hpp: numbers and shapes of the bodies that a setup asks for.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// A rod of the supply with all its lengths scaled.
Shape rod_shape(const RodSupply& rods, double scale, const Locate& locate);

/// Mean projected area of a bead of the mixture [mm^2].
double mean_area(const BeadSupply& beads);

/// `count` if it is above 0, or else the number of bodies that have the area fraction.
std::int64_t count_of(int count, double area_fraction, double area_cell, double area_body);

/// Whole numbers that sum to `count` in these proportions, by largest remainders.
std::vector<std::int64_t> apportioned(std::int64_t count, const std::vector<double>& proportions);

/// Diameter of the largest sphere of a shape [mm].
double thickness(const Shape& shape);

}  // namespace drover::dem
