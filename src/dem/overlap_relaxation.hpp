// dem/overlap_relaxation.hpp: bodies as soft spheres that push each other apart, for packings.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/bins.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// Bodies between two levels.  Their places and axes are what a packing looks for; masses are those of the search, not
/// of the bodies.
struct OverlapRelaxation {
    Cell cell;
    double floor = 0.0, ceiling = 0.0;  ///< the heights between which all spheres stay [mm]
    bool turns = true;                  ///< whether rods may turn
    double margin = 0.0;                ///< by which part spheres are larger here than they are
    double size = 1.0;                  ///< of rods beside what they are to become

    /// Of the bodies: beads, then rods.
    std::vector<Vector> position, velocity, force;
    std::vector<double> mass;
    /// Of the rods.
    std::vector<Vector> axis, turning, torque;
    std::vector<double> inertia;

    /// Of the spheres: those of the beads, then those of the rods in their order.
    std::vector<Vector> centre, push;
    std::vector<double> at, radius;  ///< along the axis; both as they are to become [mm]
    std::vector<double> reach;       ///< radius as it is now, with the margin [mm]
    std::vector<std::uint32_t> body;
};

/// Bodies with their spheres, at the origin.
OverlapRelaxation make_relaxation(const Setup& setup, const Bodies& bodies, double margin);

void set_margin(OverlapRelaxation& relaxation, double margin);

/// Sets the spheres by the places and axes of their bodies.
void set_spheres(OverlapRelaxation& relaxation);

/// Moves bodies apart, down the energy of their overlaps, until none is deeper than a part `deepest` of the pair's
/// distance, or for `steps`. Returns the deepest overlap left, as such a part.  FIRE: Bitzek et al., PRL 97, 170201
/// (2006).
double relax_overlaps(OverlapRelaxation& relaxation, double deepest, int steps);

/// Largest overlap of spheres as they are, of two bodies or with a plate or wall, beside the smaller radius; < 0 where
/// none overlap, -1 at least.
double largest_overlap(const OverlapRelaxation& relaxation);

}  // namespace drover::dem
