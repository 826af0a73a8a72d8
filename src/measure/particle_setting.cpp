// measure/particle_setting.cpp: bins, boxes, meshes and axes of the observables of particles.
#include <algorithm>
#include <cmath>

#include "measure/particles.hpp"

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

}  // namespace drover::measure
