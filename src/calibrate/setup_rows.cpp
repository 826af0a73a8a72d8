// calibrate/setup_rows.cpp: densities, masses and areas of the bodies of a setup.
#include "calibrate/setup_rows.hpp"

#include <array>
#include <cmath>

#include "drover/dem/bodies.hpp"

namespace drover::calibrate {

namespace {
SetupContent content_of(const dem::Setup& setup) {
    const dem::Bodies bodies = dem::make_bodies(setup, 0);
    const double area = dem::area(setup.cell), beads = static_cast<double>(bodies.beads.size());
    SetupContent content{.rods = static_cast<double>(bodies.rods.size()) / area, .beads = beads / area};
    for (const dem::Bead& bead : bodies.beads) {
        const dem::Shape& shape = bodies.shapes[bead.shape];
        content.bead_mass_density += shape.mass / area;
        content.bead_mass += shape.mass / beads;
        content.bead_area += shape.projected_area / beads;
    }
    dem::Setup nominal = setup;
    nominal.rods.size_tolerance = 0.0;
    const dem::Bodies nominal_bodies = dem::make_bodies(nominal, 0);
    if (!nominal_bodies.rods.empty())
        content.rod_area = nominal_bodies.shapes[nominal_bodies.rods.front().shape].projected_area;
    return content;
}

constexpr std::array<SetupRow, 6> rows_of_setups{
    {{"bead_density", "1/mm^2", "rho: beads per area of the cell", false, false, &SetupContent::beads},
     {"bead_mass_density", "mg/mm^2", "m rho: mass of the beads per area of the cell", false, false,
      &SetupContent::bead_mass_density},
     {"rod_density", "1/mm^2", "sigma: rods per area of the cell", true, true, &SetupContent::rods},
     {"bead_mass", "mg", "m: of one bead, the mean of a mixture", false, false, &SetupContent::bead_mass},
     {"bead_area", "mm^2", "Phi_b/rho: projected area of one bead, the mean of a mixture", false, false,
      &SetupContent::bead_area},
     {"rod_area", "mm^2", "Phi_r/sigma: projected area of one rod that lies", false, true, &SetupContent::rod_area}}};
}  // namespace

std::span<const SetupRow> setup_rows() { return rows_of_setups; }

double number_of(const SetupRow& row, const dem::Setup& setup) { return content_of(setup).*row.number; }

std::string remark_on(const SetupRow& row, const dem::Setup& setup) {
    if (row.number != &SetupContent::rods || setup.rods.area_fraction == 0.0) return "";
    const SetupContent content = content_of(setup);
    const double asked = setup.rods.area_fraction, covered = content.rods * content.rod_area;
    constexpr double matters = 0.02;
    if (std::abs(covered / asked - 1.0) <= matters) return "";
    return text("{:.0f} rods cover {:.4g} of the cell, not {:.4g}: c and closures take their density as {:.4g}",
                content.rods * dem::area(setup.cell), covered, asked, asked / content.rod_area);
}

}  // namespace drover::calibrate
