// measure/particle_pairs.cpp: pairs of bodies at one moment: hexatic order, correlations, beads around rods.
#include <cmath>
#include <complex>
#include <numbers>

#include "dem/neighbours/bins.hpp"
#include "measure/particles.hpp"
#include "measure/quasirandom_subset.hpp"

namespace drover::measure {

namespace {

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

/// Area of the ring of a bin.
double ring_area(const Bins& bins, std::size_t bin) {
    return std::numbers::pi * bins.width * bins.width * static_cast<double>(2 * bin + 1);
}

/// g(r) from the number of pairs in each bin: relative to a uniform gas of the same number.
std::vector<double> correlation(const ParticleSetting& setting, const Bins& bins, std::span<const double> pairs,
                                std::size_t centres, std::size_t all) {
    const double density = static_cast<double>(all - 1) / (setting.cell.lx * setting.cell.ly);
    std::vector<double> result(pairs.begin(), pairs.end());
    for (std::size_t bin = 0; bin < result.size(); ++bin)
        result[bin] /= static_cast<double>(centres) * density * ring_area(bins, bin);
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
