// dem/supply.hpp: what the supplies of a setup ask for: how many bodies, and of which shape.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// A rod of the supply with all its lengths scaled.
Shape rod_shape(const RodSupply& rods, double scale, const LocationOf& place);

/// Mean projected area of a bead of the mixture [mm^2].
double mean_area(const BeadSupply& beads);

/// How many bodies an area fraction, or a count above 0, asks for; 0 where area is 0.
std::int64_t count_of(int count, double area_fraction, double area_cell, double area_body);

/// `count` in the proportions of `parts`, each rounded down, what is left going to the largest remainders.
std::vector<std::int64_t> dealt(std::int64_t count, const std::vector<double>& parts);

/// Diameter of the largest sphere of a shape [mm].
double thickness(const Shape& shape);

}  // namespace drover::dem
