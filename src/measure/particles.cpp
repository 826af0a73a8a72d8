// measure/particles.cpp: bins, boxes and meshes of the observables of particles; means over the beads and over the rods
// at one moment, fluctuations of their numbers in boxes of a periodic cell, and pairs of bodies: hexatic order,
// correlations, beads around rods.
#include "measure/particles.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "dem/bodies/rotation.hpp"
#include "dem/neighbours/bins.hpp"
#include "measure/quasirandom_subset.hpp"

namespace drover::measure {

namespace {
constexpr double bead_bins_per_diameter = 20.0, bead_diameters = 5.0;  ///< of g(r) of beads: about five shells
constexpr double rod_bins_per_length = 8.0;                            ///< finer than a rod is wide
constexpr std::size_t max_rod_bins = 512;
constexpr int min_fine = 48;        ///< cells along the shorter side in which bodies are counted
constexpr double flow_reach = 2.5;  ///< half side of the mesh around a rod, in rod lengths
constexpr int flow_mesh = 21;       ///< odd: one cell is centred on the centre of mass

double shorter_side(const dem::Cell& cell) { return std::min(cell.lx, cell.ly); }

Bins bins_up_to(double max, double width) {
    return {.width = width, .count = static_cast<std::size_t>(std::max(max / width * (1.0 + 1e-12), 0.0))};
}

/// Boxes with at least one body on average and sides up to half of the cell.
void add_boxes(ParticleSetting& setting) {
    const double fine = shorter_side(setting.cell) / min_fine;
    setting.fine_x = static_cast<int>(std::lround(setting.cell.lx / fine));
    setting.fine_y = static_cast<int>(std::lround(setting.cell.ly / fine));
    const auto bodies = static_cast<double>(setting.rods > 0 ? setting.rods : setting.beads);
    for (const int side : {1, 2, 3, 4, 6, 8, 12, 16, 24}) {
        const double fraction =
            static_cast<double>(side) * side / (static_cast<double>(setting.fine_x) * setting.fine_y);
        if (bodies * fraction < 1.0) continue;
        setting.boxes.push_back(side);
        setting.fractions.push_back(fraction);
    }
}

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

constexpr double neighbour_reach = 1.4;  ///< in mean diameters: between the first two shells of a lattice, 1 and sqrt 3
constexpr std::size_t max_bead_centres = 8192;  ///< enough for the error; a moment takes milliseconds
constexpr std::size_t max_rod_centres = 1024, max_flow_centres = 256;

/// Beads in squares, to visit those near a point.
class NearBeads {
public:
    /// In a periodic cell `reach` must be at most half the shorter side.
    NearBeads(const dem::Cell& cell, const std::vector<dem::Bead>& beads, double reach)
        : nearest_(cell), squares_(cell, reach), beads_(beads), max_square_(reach * reach) {
        for (const dem::Bead& bead : beads) squares_.add(bead.position);
    }

    /// Calls visit(i, dx, dy) once for each bead nearer in the plane than `reach`, including one at the place itself.
    template <class Visit>
    void for_near(const dem::Vector& place, const Visit& visit) const {
        squares_.for_near(place, [&](std::size_t i) {
            const dem::Vector& there = beads_[i].position;
            const double dx = nearest_.x(there.x - place.x), dy = nearest_.y(there.y - place.y);
            if (dx * dx + dy * dy < max_square_) visit(i, dx, dy);
        });
    }

private:
    dem::NearestImage nearest_;
    dem::Bins squares_;
    const std::vector<dem::Bead>& beads_;
    double max_square_;
};

/// g(r) from the number of pairs in each bin: relative to a uniform gas of the same number.
std::vector<double> correlation(const ParticleSetting& setting, const Bins& bins, std::span<const double> pairs,
                                std::size_t centres, std::size_t all) {
    const double density = static_cast<double>(all - 1) / (setting.cell.lx * setting.cell.ly);
    std::vector<double> result(pairs.begin(), pairs.end());
    for (std::size_t bin = 0; bin < result.size(); ++bin) {
        const double ring = std::numbers::pi * bins.width * bins.width * static_cast<double>(2 * bin + 1);
        result[bin] /= static_cast<double>(centres) * density * ring;
    }
    return result;
}

void add_hexatic(const ParticleSetting& setting, const std::vector<dem::Bead>& beads, PairSums& sums) {
    const NearBeads near(setting.cell, beads, neighbour_reach * setting.bead_diameter);
    const double weight = 1.0 / static_cast<double>(beads.size());
    std::complex<double> sum;
    for (std::size_t i = 0; i < beads.size(); ++i) {
        double real = 0.0, imaginary = 0.0, count = 0.0;
        near.for_near(beads[i].position, [&](std::size_t j, double dx, double dy) {
            const double square = dx * dx + dy * dy;
            if (j == i || square == 0.0) return;
            // (dx + i dy)^6/r^6 through the square z = (dx + i dy)^2/r^2 and z^3.
            const double a = (dx * dx - dy * dy) / square, b = 2.0 * dx * dy / square;
            real += a * (a * a - 3.0 * b * b);
            imaginary += b * (3.0 * a * a - b * b);
            count += 1.0;
        });
        sums.neighbours += weight * count;
        if (count == 0.0) continue;
        const std::complex<double> psi(real / count, imaginary / count);
        sum += weight * psi;
        sums.hexatic_local += weight * std::abs(psi);
    }
    sums.hexatic = std::abs(sum);
}

void add_bead_correlation(const ParticleSetting& setting, const std::vector<dem::Bead>& beads, PairSums& sums) {
    const Bins& bins = setting.bead_separations;
    const NearBeads near(setting.cell, beads, bins.width * static_cast<double>(bins.count));
    const std::size_t all = beads.size(), centres = std::min(all, max_bead_centres);
    std::vector<double> pairs(bins.count);
    for (std::size_t k = 0; k < centres; ++k) {
        const std::size_t i = quasirandom_index(k, centres, all);
        near.for_near(beads[i].position, [&](std::size_t j, double dx, double dy) {
            const auto bin = static_cast<std::size_t>(std::sqrt(dx * dx + dy * dy) / bins.width);
            if (j != i && bin < bins.count) pairs[bin] += 1.0;
        });
    }
    sums.bead_correlation = correlation(setting, bins, pairs, centres, all);
}

/// n of each rod in the plane; in a round cell (radial, azimuthal).
std::vector<dem::Vector> directions(const ParticleSetting& setting, const dem::Bodies& bodies) {
    std::vector<dem::Vector> result;
    for (const dem::Rod& rod : bodies.rods) {
        double x = rod.axis.x, y = rod.axis.y;
        if (setting.round) {
            const double angle = std::atan2(rod.position.y, rod.position.x), c = std::cos(angle), s = std::sin(angle);
            x = c * rod.axis.x + s * rod.axis.y;
            y = c * rod.axis.y - s * rod.axis.x;
        }
        const double flat = std::hypot(x, y);
        result.push_back(flat > 0.0 ? dem::Vector{x / flat, y / flat, 0.0} : dem::Vector{});
    }
    return result;
}

void add_rod_pairs(const ParticleSetting& setting, const dem::Bodies& bodies, PairSums& sums) {
    const Bins& bins = setting.rod_separations;
    const std::vector<dem::Vector> n = directions(setting, bodies);
    const std::size_t all = n.size(), centres = std::min(all, max_rod_centres);
    const dem::NearestImage nearest(setting.cell);
    const double max_square = std::pow(bins.width * static_cast<double>(bins.count), 2);
    std::vector<double> pairs(bins.count), order(bins.count);
    for (std::size_t k = 0; k < centres; ++k) {
        const std::size_t i = quasirandom_index(k, centres, all);
        for (std::size_t j = 0; j < all; ++j) {
            const dem::Vector d = nearest(bodies.rods[i].position, bodies.rods[j].position);
            const double square = d.x * d.x + d.y * d.y;
            if (square >= max_square || j == i) continue;
            const auto bin = std::min(static_cast<std::size_t>(std::sqrt(square) / bins.width), bins.count - 1);
            pairs[bin] += 1.0;
            order[bin] += n[i].x * n[j].x + n[i].y * n[j].y;
        }
    }
    double mean_x = 0.0, mean_y = 0.0;
    for (std::size_t i = 0; i < all; ++i) {
        mean_x += n[i].x / static_cast<double>(all);
        mean_y += n[i].y / static_cast<double>(all);
    }
    if (setting.periodic) sums.rod_correlation = correlation(setting, bins, pairs, centres, all);
    for (std::size_t bin = 0; bin < bins.count; ++bin) {
        const double count = pairs[bin] / static_cast<double>(centres), sum = order[bin] / static_cast<double>(centres);
        sums.rod_pairs.push_back(count);
        sums.rod_pairs_order.push_back(sum);
        sums.rod_pairs_excess.push_back(sum - count * (mean_x * mean_x + mean_y * mean_y));
    }
}

void add_flow(const ParticleSetting& setting, const dem::Bodies& bodies, PairSums& sums) {
    const auto mesh = static_cast<std::size_t>(setting.mesh);
    const double width = setting.mesh_width, half = 0.5 * width * setting.mesh;
    const NearBeads near(setting.cell, bodies.beads, std::sqrt(2.0) * half);
    const std::size_t centres = std::min(bodies.rods.size(), max_flow_centres);
    const double weight = 1.0 / (static_cast<double>(centres) * width * width);
    for (auto* field : {&sums.flow_density, &sums.flow_along, &sums.flow_across}) field->assign(mesh * mesh, 0.0);
    for (std::size_t k = 0; k < centres; ++k) {
        const dem::Rod& rod = bodies.rods[quasirandom_index(k, centres, bodies.rods.size())];
        const double flat = std::hypot(rod.axis.x, rod.axis.y);
        if (flat == 0.0) continue;
        const double c = rod.axis.x / flat, s = rod.axis.y / flat;
        near.for_near(rod.position, [&](std::size_t j, double dx, double dy) {
            const double along = (c * dx + s * dy + half) / width, across = (c * dy - s * dx + half) / width;
            if (along < 0.0 || across < 0.0) return;
            const auto row = static_cast<std::size_t>(along), column = static_cast<std::size_t>(across);
            if (row >= mesh || column >= mesh) return;
            const dem::Vector& v = bodies.beads[j].velocity;
            sums.flow_density[row * mesh + column] += weight;
            sums.flow_along[row * mesh + column] += weight * (c * v.x + s * v.y);
            sums.flow_across[row * mesh + column] += weight * (c * v.y - s * v.x);
        });
    }
}
}  // namespace

ParticleSetting make_particle_setting(const dem::Setup& setup, const dem::Bodies& at_start) {
    ParticleSetting setting{.cell = setup.cell,
                            .periodic = dem::is_periodic(setup.cell),
                            .round = setup.cell.shape == dem::CellShape::circle ||
                                     setup.cell.shape == dem::CellShape::flower,
                            .beads = at_start.beads.size(),
                            .rods = at_start.rods.size()};
    for (const dem::Bead& bead : at_start.beads)
        setting.bead_diameter += 2.0 * at_start.shapes[bead.shape].radius[0] / static_cast<double>(setting.beads);
    for (const dem::Rod& rod : at_start.rods) {
        const dem::Shape& shape = at_start.shapes[rod.shape];
        setting.rod_length += (shape.head - shape.tail) / static_cast<double>(setting.rods);
    }
    const double half = setting.round ? setup.cell.radius : 0.5 * shorter_side(setup.cell);
    if (setting.beads > 1)
        setting.bead_separations = bins_up_to(std::min(half, bead_diameters * setting.bead_diameter),
                                              setting.bead_diameter / bead_bins_per_diameter);
    if (setting.rods > 1) {
        setting.rod_separations = bins_up_to(half, setting.rod_length / rod_bins_per_length);
        setting.rod_separations.count = std::min(setting.rod_separations.count, max_rod_bins);
    }
    if (setting.periodic && setting.beads + setting.rods > 0) add_boxes(setting);
    if (setting.rods > 0 && setting.beads > 0) {
        // The corners of the mesh stay within half of the cell, so that each bead has one image on it.
        setting.mesh = flow_mesh;
        setting.mesh_width = 2.0 * std::min(flow_reach * setting.rod_length, half / std::sqrt(2.0)) / flow_mesh;
    }
    return setting;
}

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

PairSums pair_sums(const ParticleSetting& setting, const dem::Bodies& bodies) {
    PairSums sums;
    if (!bodies.beads.empty()) {
        add_hexatic(setting, bodies.beads, sums);
        if (setting.periodic && setting.bead_separations.count > 0) add_bead_correlation(setting, bodies.beads, sums);
        if (setting.mesh > 0) add_flow(setting, bodies, sums);
    }
    if (setting.rod_separations.count > 0) add_rod_pairs(setting, bodies, sums);
    return sums;
}

}  // namespace drover::measure
