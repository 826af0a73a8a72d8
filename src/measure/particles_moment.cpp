// measure/particles_moment.cpp: means over the beads and over the rods at one moment.
#include <cmath>
#include <complex>

#include "drover/dem/rotation.hpp"
#include "drover/measure/particles.hpp"

namespace drover::measure {

namespace {

/// Components of (ax, ay) at a place, along and across the line from the origin; none at the origin itself.
struct Polar {
    double radial = 0.0, azimuthal = 0.0;
};
Polar polar(const dem::Vector& place, double ax, double ay) {
    const double r = std::hypot(place.x, place.y);
    if (r == 0.0) return {};
    return {(ax * place.x + ay * place.y) / r, (ay * place.x - ax * place.y) / r};
}

}  // namespace

BeadMeans bead_means(const ParticleSetting& setting, const dem::Bodies& bodies) {
    BeadMeans mean;
    if (bodies.beads.empty()) return mean;
    const double part = 1.0 / static_cast<double>(bodies.beads.size());
    double velocity_z = 0.0;
    for (const dem::Bead& bead : bodies.beads) {
        const dem::Vector& v = bead.velocity;
        const double speed = std::sqrt(v.x * v.x + v.y * v.y), per_speed = speed > 0.0 ? 1.0 / speed : 0.0;
        mean.velocity_x += part * v.x;
        mean.velocity_y += part * v.y;
        velocity_z += part * v.z;
        mean.speed += part * speed;
        mean.direction_x += part * per_speed * v.x;
        mean.direction_y += part * per_speed * v.y;
        mean.height += part * bead.position.z;
        if (!setting.round) continue;
        const Polar local = polar(bead.position, v.x, v.y);
        mean.velocity_radial += part * local.radial;
        mean.velocity_azimuthal += part * local.azimuthal;
        mean.direction_radial += part * per_speed * local.radial;
        mean.direction_azimuthal += part * per_speed * local.azimuthal;
    }
    for (const dem::Bead& bead : bodies.beads) {
        const double x = bead.velocity.x - mean.velocity_x, y = bead.velocity.y - mean.velocity_y,
                     z = bead.velocity.z - velocity_z, weight = part * bodies.shapes[bead.shape].mass;
        mean.temperature_horizontal += 0.5 * weight * (x * x + y * y);
        mean.temperature_vertical += weight * z * z;
    }
    return mean;
}

RodMeans rod_means(const ParticleSetting& setting, const dem::Bodies& bodies) {
    RodMeans mean;
    if (bodies.rods.empty()) return mean;
    const double part = 1.0 / static_cast<double>(bodies.rods.size());
    double velocity_z = 0.0, along_squares = 0.0, tilt_square = 0.0;
    std::complex<double> nematic;
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Vector &n = rod.axis, &v = rod.velocity;
        const double flat = std::hypot(n.x, n.y), per_flat = flat > 0.0 ? 1.0 / flat : 0.0;
        const double nx = per_flat * n.x, ny = per_flat * n.y, along = v.x * nx + v.y * ny;
        mean.order_x += part * nx;
        mean.order_y += part * ny;
        nematic += part * std::complex(nx * nx - ny * ny, 2.0 * nx * ny);
        mean.velocity_x += part * v.x;
        mean.velocity_y += part * v.y;
        velocity_z += part * v.z;
        mean.velocity_along += part * along;
        tilt_square += part * n.z * n.z;
        mean.height += part * rod.position.z;
        if (!setting.round) continue;
        const Polar order = polar(rod.position, nx, ny), velocity = polar(rod.position, v.x, v.y);
        mean.order_radial += part * order.radial;
        mean.order_azimuthal += part * order.azimuthal;
        mean.velocity_radial += part * velocity.radial;
        mean.velocity_azimuthal += part * velocity.azimuthal;
    }
    mean.order_nematic = std::abs(nematic);
    mean.tilt = std::sqrt(tilt_square);
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Shape& shape = bodies.shapes[rod.shape];
        const double x = rod.velocity.x - mean.velocity_x, y = rod.velocity.y - mean.velocity_y,
                     z = rod.velocity.z - velocity_z;
        const double turning =
            dem::angular_velocity(rod.angular_momentum, rod.axis, shape.inertia_along, shape.inertia_across).z;
        mean.temperature_horizontal += 0.5 * part * shape.mass * (x * x + y * y);
        mean.temperature_vertical += part * shape.mass * z * z;
        mean.temperature_turning += part * shape.inertia_across * turning * turning;
        const double flat = std::hypot(rod.axis.x, rod.axis.y);
        if (flat == 0.0) continue;
        const double along = (rod.velocity.x * rod.axis.x + rod.velocity.y * rod.axis.y) / flat - mean.velocity_along;
        along_squares += along * along;
    }
    if (bodies.rods.size() > 1)
        mean.velocity_along_deviation = std::sqrt(along_squares / static_cast<double>(bodies.rods.size() - 1));
    return mean;
}

std::vector<double> rates(std::span<const double> accumulated, double spacing) {
    std::vector<double> result;
    for (std::size_t i = 0; i + 1 < accumulated.size(); ++i)
        result.push_back((accumulated[i + 1] - accumulated[i]) / spacing);
    return result;
}

}  // namespace drover::measure
