// dem/bodies.hpp: the bodies of a particle world at one time, as plain data.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/dem/setup.hpp"
#include "drover/dem/shape.hpp"
#include "drover/dem/vector.hpp"

namespace drover::dem {

struct Bead {
    Vector position;          ///< of its centre [mm], not wrapped into a periodic cell
    Vector velocity;          ///< [mm/s]
    Vector spin;              ///< angular velocity [rad/s]
    std::uint32_t shape = 0;  ///< of Bodies::shapes
};

struct Rod {
    Vector position;             ///< of its centre of mass [mm], not wrapped
    Vector velocity;             ///< [mm/s]
    Vector axis{1.0, 0.0, 0.0};  ///< n, from tail to head, of length 1
    Vector angular_momentum;     ///< [mg mm^2/s]
    std::uint32_t shape = 0;     ///< of Bodies::shapes
};

/// Bodies keep their indices in these lists throughout a run.
struct Bodies {
    std::vector<Shape> shapes;
    std::vector<Bead> beads;
    std::vector<Rod> rods;
};

/// The bodies that a setup asks for, at rest at the origin; a packing places them.  The diameters of a mixture are
/// distributed in their proportions, rounded by largest remainders; the sizes of rods are drawn from the seed.  Throws
/// an input Error for an impossible shape.
Bodies make_bodies(const Setup& setup, std::uint64_t seed, const Locate& locate = no_location);

/// The shapes of these bodies, rods at their mean size.
std::vector<Shape> shapes_of(const Setup& setup, const Locate& locate = no_location);

/// Area of the cell in the plane [mm^2].
double area(const Cell& cell);

}  // namespace drover::dem
