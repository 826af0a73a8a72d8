// measure/particles_boxes.cpp: numbers of bodies in boxes of a periodic cell.
#include "measure/particles_boxes.hpp"

#include <algorithm>
#include <cmath>

namespace drover::measure {

namespace {

/// Which of `count` equal parts of a period a place lies in.
std::size_t part_of(double place, double side, int count) {
    const double turns = place / side;
    return static_cast<std::size_t>(std::min(static_cast<int>((turns - std::floor(turns)) * count), count - 1));
}

}  // namespace

void box_variances(const ParticleSetting& setting, std::span<const dem::Vector> places, std::span<double> out) {
    const auto nx = static_cast<std::size_t>(setting.fine_x), ny = static_cast<std::size_t>(setting.fine_y);
    std::vector<double> count(nx * ny);
    for (const dem::Vector& place : places)
        count[part_of(place.y, setting.cell.ly, setting.fine_y) * nx +
              part_of(place.x, setting.cell.lx, setting.fine_x)] += 1.0;
    // below[j][i]: bodies in the cells of rows < j and columns < i of the mesh repeated once along each side.
    const std::size_t wide = 2 * nx + 1;
    std::vector<double> below(wide * (2 * ny + 1));
    for (std::size_t j = 0; j < 2 * ny; ++j)
        for (std::size_t i = 0; i < 2 * nx; ++i)
            below[(j + 1) * wide + i + 1] = count[(j % ny) * nx + i % nx] + below[j * wide + i + 1] +
                                            below[(j + 1) * wide + i] - below[j * wide + i];
    for (std::size_t b = 0; b < setting.boxes.size(); ++b) {
        const auto side = static_cast<std::size_t>(setting.boxes[b]);
        const double mean = static_cast<double>(places.size()) * setting.part[b];
        double squares = 0.0;
        for (std::size_t j = 0; j < ny; ++j)
            for (std::size_t i = 0; i < nx; ++i) {
                const double number = below[(j + side) * wide + i + side] - below[j * wide + i + side] -
                                      below[(j + side) * wide + i] + below[j * wide + i];
                squares += (number - mean) * (number - mean);
            }
        out[b] = squares / static_cast<double>(nx * ny);
    }
}

}  // namespace drover::measure
