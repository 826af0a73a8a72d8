// tests/dem/packing_support.hpp: setups to pack, and a look at packings that shares nothing with how they were made.
#pragma once
#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "dem/bodies/walls.hpp"
#include "dem/packing/packing.hpp"

namespace drover::dem {

inline Setup mixture(double side, double beads, double rods) {
    Setup setup;
    setup.cell.lx = setup.cell.ly = side;
    setup.beads.area_fraction = beads;
    setup.rods.area_fraction = rods;
    return setup;
}

struct PlacedSphere {
    Vector centre;
    double radius = 0.0;
    std::size_t body = 0;
    bool image = false;
};

inline std::vector<PlacedSphere> spheres_of(const Bodies& bodies) {
    std::vector<PlacedSphere> spheres;
    std::size_t body = 0;
    for (const Bead& bead : bodies.beads)
        spheres.push_back({bead.position, bodies.shapes[bead.shape].radius.front(), body++});
    for (const Rod& rod : bodies.rods) {
        const Shape& shape = bodies.shapes[rod.shape];
        for (std::size_t i = 0; i < shape.at.size(); ++i)
            spheres.push_back({rod.position + shape.at[i] * rod.axis, shape.radius[i], body});
        ++body;
    }
    return spheres;
}

/// Adds the images, over the edges of a periodic cell, of what is near an edge.
inline void add_images(const Cell& cell, double reach, std::vector<PlacedSphere>& spheres) {
    const std::size_t count = spheres.size();
    for (std::size_t i = 0; i < count; ++i)
        for (int kx = -2; kx <= 2; ++kx)
            for (int ky = -2; ky <= 2; ++ky) {
                const Vector at = spheres[i].centre + Vector{kx * cell.lx, ky * cell.ly, 0.0};
                const bool near =
                    std::abs(at.x) < cell.lx / 2 + reach + 5.0 && std::abs(at.y) < cell.ly / 2 + reach + 5.0;
                if ((kx != 0 || ky != 0) && near) spheres.push_back({at, spheres[i].radius, spheres[i].body, true});
            }
}

/// The deepest overlap of any two bodies or of one with a plate or wall [mm]; < 0: the least gap.
inline double deepest(const Setup& setup, const Bodies& bodies) {
    std::vector<PlacedSphere> spheres = spheres_of(bodies);
    double most = -1e300, largest = 0.0;
    const double base = 2.0 * setup.plates.amplitude;
    for (const PlacedSphere& s : spheres) {
        largest = std::max(largest, s.radius);
        most = std::max(most, base + s.radius - s.centre.z);
        if (setup.plates.lid) most = std::max(most, s.centre.z + s.radius - base - setup.plates.gap);
        WallPoint found[4];
        if (Walls(setup.cell).near(s.centre.x, s.centre.y, s.radius, found) > 0)
            most = std::max(most, s.radius - found[0].distance);
    }
    if (setup.cell.shape == CellShape::periodic) add_images(setup.cell, 2.0 * largest, spheres);
    std::sort(spheres.begin(), spheres.end(),
              [](const PlacedSphere& a, const PlacedSphere& b) { return a.centre.x < b.centre.x; });
    for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = i + 1; j < spheres.size(); ++j) {
            const PlacedSphere &a = spheres[i], &b = spheres[j];
            if (b.centre.x - a.centre.x > 2.0 * largest) break;
            if (a.body == b.body && a.image == b.image) continue;
            if (a.image && b.image) continue;
            most = std::max(most, a.radius + b.radius - length(a.centre - b.centre));
        }
    return most;
}

/// Sum over rods of e^(i k angle), over their number: k = 1 the polar order, 2 the nematic.
inline std::complex<double> order(const Bodies& bodies, int k) {
    std::complex<double> sum;
    for (const Rod& rod : bodies.rods) sum += std::polar(1.0, k * std::atan2(rod.axis.y, rod.axis.x));
    return sum / static_cast<double>(bodies.rods.size());
}

}  // namespace drover::dem
