// measure/particle_means.cpp: means over the beads and over the rods at one moment, and fluctuations of their numbers
// in boxes of a periodic cell.
#include <algorithm>
#include <cmath>
#include <complex>

#include "dem/bodies/rotation.hpp"
#include "measure/particles.hpp"

namespace drover::measure {

namespace {

/// Radial and azimuthal components of the vector (ax, ay) at a position; zero at the origin.
struct Polar {
    double radial = 0.0, azimuthal = 0.0;
};
Polar polar(const dem::Vector& position, double ax, double ay) {
    const double r = std::hypot(position.x, position.y);
    if (r == 0.0) return {};
    return {(ax * position.x + ay * position.y) / r, (ay * position.x - ax * position.y) / r};
}

/// Which of `count` equal intervals of a period contains a coordinate.
std::size_t interval_of(double coordinate, double period, int count) {
    const double periods = coordinate / period;
    return static_cast<std::size_t>(std::min(static_cast<int>((periods - std::floor(periods)) * count), count - 1));
}

}  // namespace

BeadMeans bead_means(const ParticleSetting& setting, const dem::Bodies& bodies) {
    BeadMeans mean;
    if (bodies.beads.empty()) return mean;
    const double weight = 1.0 / static_cast<double>(bodies.beads.size());
    double velocity_z = 0.0;
    for (const dem::Bead& bead : bodies.beads) {
        const dem::Vector& v = bead.velocity;
        const double square = v.x * v.x + v.y * v.y, speed = std::sqrt(square),
                     per_speed = speed > 0.0 ? 1.0 / speed : 0.0;
        mean.velocity_x += weight * v.x;
        mean.velocity_y += weight * v.y;
        velocity_z += weight * v.z;
        mean.velocity_square += weight * square;
        mean.direction_x += weight * per_speed * v.x;
        mean.direction_y += weight * per_speed * v.y;
        mean.height += weight * bead.position.z;
        if (!setting.round) continue;
        const Polar local = polar(bead.position, v.x, v.y);
        mean.velocity_radial += weight * local.radial;
        mean.velocity_azimuthal += weight * local.azimuthal;
        mean.direction_radial += weight * per_speed * local.radial;
        mean.direction_azimuthal += weight * per_speed * local.azimuthal;
    }
    for (const dem::Bead& bead : bodies.beads) {
        const double x = bead.velocity.x - mean.velocity_x, y = bead.velocity.y - mean.velocity_y,
                     z = bead.velocity.z - velocity_z, mass = weight * bodies.shapes[bead.shape].mass;
        mean.temperature_horizontal += 0.5 * mass * (x * x + y * y);
        mean.temperature_vertical += mass * z * z;
    }
    return mean;
}

RodMeans rod_means(const ParticleSetting& setting, const dem::Bodies& bodies) {
    RodMeans mean;
    if (bodies.rods.empty()) return mean;
    const double weight = 1.0 / static_cast<double>(bodies.rods.size());
    double velocity_z = 0.0, along_squares = 0.0, tilt_square = 0.0;
    std::complex<double> nematic;
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Vector &n = rod.axis, &v = rod.velocity;
        const double flat = std::hypot(n.x, n.y), per_flat = flat > 0.0 ? 1.0 / flat : 0.0;
        const double nx = per_flat * n.x, ny = per_flat * n.y, along = v.x * nx + v.y * ny;
        mean.order_x += weight * nx;
        mean.order_y += weight * ny;
        nematic += weight * std::complex(nx * nx - ny * ny, 2.0 * nx * ny);
        mean.velocity_x += weight * v.x;
        mean.velocity_y += weight * v.y;
        velocity_z += weight * v.z;
        mean.velocity_along += weight * along;
        tilt_square += weight * n.z * n.z;
        mean.height += weight * rod.position.z;
        if (!setting.round) continue;
        const Polar order = polar(rod.position, nx, ny), velocity = polar(rod.position, v.x, v.y);
        mean.order_radial += weight * order.radial;
        mean.order_azimuthal += weight * order.azimuthal;
        mean.velocity_radial += weight * velocity.radial;
        mean.velocity_azimuthal += weight * velocity.azimuthal;
    }
    mean.order_nematic = std::abs(nematic);
    mean.tilt = std::sqrt(tilt_square);
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Shape& shape = bodies.shapes[rod.shape];
        const double x = rod.velocity.x - mean.velocity_x, y = rod.velocity.y - mean.velocity_y,
                     z = rod.velocity.z - velocity_z;
        const double turning = dem::angular_velocity(rod, shape).z;
        mean.temperature_horizontal += 0.5 * weight * shape.mass * (x * x + y * y);
        mean.temperature_vertical += weight * shape.mass * z * z;
        mean.temperature_turning += weight * shape.inertia_across * turning * turning;
        const double flat = std::hypot(rod.axis.x, rod.axis.y);
        if (flat == 0.0) continue;
        const double along = (rod.velocity.x * rod.axis.x + rod.velocity.y * rod.axis.y) / flat - mean.velocity_along;
        along_squares += along * along;
    }
    if (bodies.rods.size() > 1)
        mean.velocity_along_deviation = std::sqrt(along_squares / static_cast<double>(bodies.rods.size() - 1));
    return mean;
}

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
