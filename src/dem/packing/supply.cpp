// dem/packing/supply.cpp: the bodies that a setup asks for, and the area of its cell.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "dem/bodies/walls.hpp"
#include "dem/packing/supply.hpp"
#include "drover/base/random.hpp"

namespace drover::dem {

using std::numbers::pi;

double thickness(const Shape& shape) { return 2.0 * *std::ranges::max_element(shape.radius); }

Shape rod_shape(const RodSupply& rods, double scale, const Locate& locate) {
    std::vector<double> diameters = rods.diameters;
    for (double& diameter : diameters) diameter *= scale;
    if (rods.densities.size() == 1)
        return make_rod(diameters, scale * rods.length, rods.densities.front(), locate("rods.length"));
    require(rods.densities.size() == diameters.size(), locate("rods.densities"),
            "rods.densities has {} numbers beside {} of rods.diameters; expected one, or one for each sphere",
            rods.densities.size(), diameters.size());
    const Shape even = make_rod(diameters, scale * rods.length, 1.0, locate("rods.length"));
    std::vector<AxisSphere> spheres;
    for (std::size_t i = 0; i < diameters.size(); ++i)
        spheres.push_back({.at = even.at[i], .radius = even.radius[i], .density = rods.densities[i]});
    return make_shape(std::move(spheres), locate("rods.densities"));
}

double mean_area(const BeadSupply& beads) {
    double areas = 0.0, weights = 0.0;
    for (std::size_t i = 0; i < beads.diameters.size(); ++i) {
        areas += beads.proportions[i] * pi / 4.0 * beads.diameters[i] * beads.diameters[i];
        weights += beads.proportions[i];
    }
    return areas / weights;
}

std::int64_t count_of(int count, double area_fraction, double area_cell, double area_body) {
    if (count > 0) return count;
    return static_cast<std::int64_t>(std::round(area_fraction * area_cell / area_body));
}

std::vector<std::int64_t> apportioned(std::int64_t count, const std::vector<double>& proportions) {
    const double sum = std::accumulate(proportions.begin(), proportions.end(), 0.0);
    std::vector<std::int64_t> result;
    std::vector<double> remainder;
    std::int64_t left = count;
    for (const double part : proportions) {
        const double share = static_cast<double>(count) * part / sum;
        result.push_back(static_cast<std::int64_t>(std::floor(share)));
        remainder.push_back(share - std::floor(share));
        left -= result.back();
    }
    for (; left > 0; --left) {
        const auto largest = std::ranges::max_element(remainder);
        ++result[static_cast<std::size_t>(largest - remainder.begin())];
        *largest = -1.0;
    }
    return result;
}

namespace {
void add_beads(const BeadSupply& supply, double area_cell, const Locate& locate, Bodies& bodies) {
    const std::int64_t count = count_of(supply.count, supply.area_fraction, area_cell, mean_area(supply));
    const std::vector<std::int64_t> counts = apportioned(count, supply.proportions);
    std::vector<double> known;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] == 0) continue;
        const auto same = std::ranges::find(known, supply.diameters[i]);
        const auto shape = static_cast<std::uint32_t>(same - known.begin());
        if (same == known.end()) {
            known.push_back(supply.diameters[i]);
            bodies.shapes.push_back(make_ball(supply.diameters[i], supply.density, locate("beads.diameters")));
        }
        bodies.beads.insert(bodies.beads.end(), static_cast<std::size_t>(counts[i]), Bead{.shape = shape});
    }
}

void add_rods(const RodSupply& supply, double area_cell, std::uint64_t seed, const Locate& locate, Bodies& bodies) {
    const Shape standard = rod_shape(supply, 1.0, locate);
    const auto count =
        static_cast<std::size_t>(count_of(supply.count, supply.area_fraction, area_cell, standard.projected_area));
    if (count == 0) return;
    const auto first = static_cast<std::uint32_t>(bodies.shapes.size());
    bodies.rods.assign(count, Rod{.shape = first});
    if (supply.size_tolerance == 0.0) {
        bodies.shapes.push_back(standard);
        return;
    }
    std::vector<double> size(count);
    fill_normal({.seed = seed, .stream = Stream::packing}, 0, 1, size);
    for (std::size_t i = 0; i < count; ++i) {
        const double scale = 1.0 + supply.size_tolerance * size[i];
        require(scale > 0.0, locate("rods.size_tolerance"),
                "rods.size_tolerance = {} makes a rod {} times its size; expected less", supply.size_tolerance, scale);
        bodies.shapes.push_back(rod_shape(supply, scale, locate));
        bodies.rods[i].shape = first + static_cast<std::uint32_t>(i);
    }
}
}  // namespace

Bodies make_bodies(const Setup& setup, std::uint64_t seed, const Locate& locate) {
    Bodies bodies;
    const double area_cell = area(setup.cell);
    if (setup.beads.any()) add_beads(setup.beads, area_cell, locate, bodies);
    if (setup.rods.any()) add_rods(setup.rods, area_cell, seed, locate, bodies);
    if (!setup.plates.lid) return bodies;
    for (const Shape& shape : bodies.shapes)
        require(
            thickness(shape) < setup.plates.gap, locate("plates.gap"),
            "plates.gap = {} mm with a body {:.6g} mm thick; expected a gap that every body fits, those made larger by "
            "rods.size_tolerance = {} too",
            setup.plates.gap, thickness(shape), setup.rods.size_tolerance);
    return bodies;
}

std::vector<Shape> shapes_of(const Setup& setup, const Locate& locate) {
    std::vector<Shape> shapes;
    if (setup.beads.any())
        for (const double diameter : setup.beads.diameters)
            shapes.push_back(make_ball(diameter, setup.beads.density, locate("beads.diameters")));
    if (setup.rods.any()) shapes.push_back(rod_shape(setup.rods, 1.0, locate));
    return shapes;
}

double area(const Cell& cell) {
    if (cell.shape == CellShape::circle) return pi * cell.radius * cell.radius;
    if (cell.shape != CellShape::flower) return cell.lx * cell.ly;
    const Flower flower = make_flower(cell);
    const double segment = flower.arc_radius * flower.arc_radius * flower.half_angle -
                           flower.half_chord * (flower.chord_at - flower.arc_at);
    return cell.petals * (flower.half_chord * flower.chord_at + segment);
}

}  // namespace drover::dem
