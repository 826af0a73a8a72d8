// measure/particle_boxes.cpp: fluctuations of the number of bodies in boxes of a periodic cell.
#include <algorithm>
#include <cmath>

#include "measure/particles.hpp"

namespace drover::measure {

namespace {

/// Which of `count` equal intervals of a period contains a coordinate.
std::size_t interval_of(double coordinate, double period, int count) {
    const double periods = coordinate / period;
    return static_cast<std::size_t>(std::min(static_cast<int>((periods - std::floor(periods)) * count), count - 1));
}

}  // namespace

std::vector<double> box_variances(const ParticleSetting& setting, std::span<const dem::Vector> positions) {
    const auto nx = static_cast<std::size_t>(setting.fine_x), ny = static_cast<std::size_t>(setting.fine_y);
    std::vector<double> count(nx * ny);
    for (const dem::Vector& position : positions)
        count[interval_of(position.y, setting.cell.ly, setting.fine_y) * nx +
              interval_of(position.x, setting.cell.lx, setting.fine_x)] += 1.0;
    // below[j][i]: bodies in the cells of rows < j and columns < i of the mesh repeated once along each side.
    const std::size_t wide = 2 * nx + 1;
    std::vector<double> below(wide * (2 * ny + 1));
    for (std::size_t j = 0; j < 2 * ny; ++j)
        for (std::size_t i = 0; i < 2 * nx; ++i)
            below[(j + 1) * wide + i + 1] = count[(j % ny) * nx + i % nx] + below[j * wide + i + 1] +
                                            below[(j + 1) * wide + i] - below[j * wide + i];
    std::vector<double> variances;
    for (std::size_t b = 0; b < setting.boxes.size(); ++b) {
        const auto side = static_cast<std::size_t>(setting.boxes[b]);
        const double mean = static_cast<double>(positions.size()) * setting.fractions[b];
        double squares = 0.0;
        for (std::size_t j = 0; j < ny; ++j)
            for (std::size_t i = 0; i < nx; ++i) {
                const double number = below[(j + side) * wide + i + side] - below[j * wide + i + side] -
                                      below[(j + side) * wide + i] + below[j * wide + i];
                squares += (number - mean) * (number - mean);
            }
        variances.push_back(squares / static_cast<double>(nx * ny));
    }
    return variances;
}

}  // namespace drover::measure
