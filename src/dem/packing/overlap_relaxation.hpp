// dem/packing/overlap_relaxation.hpp: relaxation of overlaps, for packings.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/bodies/walls.hpp"
#include "dem/neighbours/bins.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// Bodies between two heights.  Masses and inertias are those of the minimisation, not of the bodies.
struct OverlapRelaxation {
    Cell cell;
    Walls walls;
    double floor = 0.0, ceiling = 0.0;  ///< limits of the heights of all spheres [mm]
    bool turns = true;                  ///< whether rods may turn
    double margin = 0.0;                ///< relative enlargement of the spheres
    double size = 1.0;                  ///< of rods, relative to their final size

    /// Of the bodies: beads, then rods.
    std::vector<Vector> position, velocity, force;
    std::vector<double> mass;
    /// Of the rods.
    std::vector<Vector> axis, turning, torque;
    std::vector<double> inertia;

    /// Of the spheres: those of the beads, then those of the rods in their order.
    std::vector<Vector> centre, push;
    std::vector<double> at, radius;  ///< position on the axis, and radius, at final size [mm]
    std::vector<double> reach;       ///< present radius with the margin [mm]
    std::vector<std::uint32_t> body;
};

/// The bodies at the origin.
OverlapRelaxation make_relaxation(const Setup& setup, const Bodies& bodies, double margin);

void set_margin(OverlapRelaxation& relaxation, double margin);

/// Sets the spheres from the positions and axes of the bodies.
void set_spheres(OverlapRelaxation& relaxation);

/// Minimises the energy of the overlaps until none is deeper than max_overlap times the sum of the radii, or for
/// `steps`. Returns the deepest remaining overlap in the same measure.  FIRE: Bitzek et al., PRL 97, 170201 (2006).
double relax_overlaps(OverlapRelaxation& relaxation, double max_overlap, int steps);

/// Largest overlap without the margin, of two bodies or with a plate or wall, relative to the smaller radius; between
/// -1 and 0 if there is none.
double largest_overlap(const OverlapRelaxation& relaxation);

}  // namespace drover::dem
