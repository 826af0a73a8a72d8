// calibrate/setup_rows.cpp: densities, masses and areas of the bodies of a setup.
#include "calibrate/setup_rows.hpp"

#include <cmath>

#include "drover/dem/bodies.hpp"

namespace drover::calibrate {

std::vector<SetupRow> setup_rows(const dem::Setup& setup) {
    const dem::Bodies bodies = dem::make_bodies(setup, 0);
    const double area = dem::area(setup.cell), beads = static_cast<double>(bodies.beads.size()),
                 rods = static_cast<double>(bodies.rods.size());
    double mass_density = 0.0, bead_mass = 0.0, bead_area = 0.0, rod_area = 0.0;
    for (const dem::Bead& bead : bodies.beads) {
        const dem::Shape& shape = bodies.shapes[bead.shape];
        mass_density += shape.mass / area;
        bead_mass += shape.mass / beads;
        bead_area += shape.projected_area / beads;
    }
    dem::Setup nominal = setup;
    nominal.rods.size_tolerance = 0.0;
    const dem::Bodies nominal_bodies = dem::make_bodies(nominal, 0);
    if (!nominal_bodies.rods.empty())
        rod_area = nominal_bodies.shapes[nominal_bodies.rods.front().shape].projected_area;
    const double asked = setup.rods.area_fraction, covered = rods / area * rod_area;
    constexpr double matters = 0.02;
    std::string remark;
    if (asked != 0.0 && std::abs(covered / asked - 1.0) > matters)
        remark = text("{:.0f} rods cover {:.4g} of the cell, not {:.4g}: c and closures take their density as {:.4g}",
                      rods, covered, asked, asked / rod_area);
    return {{"bead_density", "1/mm^2", "rho: beads per area of the cell", false, false, beads / area},
            {"bead_mass_density", "mg/mm^2", "m rho: mass of the beads per area of the cell", false, false,
             mass_density},
            {"rod_density", "1/mm^2", "sigma: rods per area of the cell", true, true, rods / area, remark},
            {"bead_mass", "mg", "m: of one bead, the mean of a mixture", false, false, bead_mass},
            {"bead_area", "mm^2", "Phi_b/rho: projected area of one bead, the mean of a mixture", false, false,
             bead_area},
            {"rod_area", "mm^2", "Phi_r/sigma: projected area of one rod that lies", false, true, rod_area}};
}

}  // namespace drover::calibrate
