// dem/bodies.hpp: vectors, rigid shapes, and the bodies of a particle world at one time, as plain data.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/dem/setup.hpp"

namespace drover::dem {

struct Vector {
    double x = 0.0, y = 0.0, z = 0.0;
};
inline Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(double s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }

/// A sphere of which a body is made.
struct AxisSphere {
    double at = 0.0;       ///< position of its centre on the axis, from any origin towards the head [mm]
    double radius = 0.0;   ///< [mm] > 0
    double density = 0.0;  ///< of the solid where this sphere is the widest [mg/mm^3] >= 0
};

/// One solid.  Positions are on the axis n, from tail to head, relative to the centre of mass.
struct Shape {
    std::vector<double> at, radius;  ///< of its spheres [mm], tail first
    double mass = 0.0;               ///< [mg]
    double inertia_along = 0.0;      ///< about the axis [mg mm^2]
    double inertia_across = 0.0;     ///< about any perpendicular axis through the centre of mass [mg mm^2]
    double volume = 0.0;             ///< [mm^3]
    double projected_area = 0.0;     ///< perpendicular to the axis, for area fractions of lying bodies [mm^2]
    double tail = 0.0, head = 0.0;   ///< the tips [mm]: tail < 0 < head
};

/// The union of spheres, which need not overlap.  Mass, centre and inertia are exact: the radius of the solid is that
/// of the widest sphere, r^2 = R_i^2 - (z - z_i)^2, and the integrals between the points where two spheres are equally
/// wide are elementary. Throws an input Error for no sphere, a radius that is not positive or a mass of zero.
Shape make_shape(std::vector<AxisSphere> spheres, const SourceLocation& where = {});

/// Equally spaced spheres, tail to head, of one density [mg/mm^3] and a length from tip to tip [mm].  A single diameter
/// gives a ball.  Throws an input Error where a sphere between the first and the last reaches beyond them.
Shape make_rod(const std::vector<double>& diameters, double length, double density, const SourceLocation& where = {});

Shape make_ball(double diameter, double density, const SourceLocation& where = {});

struct Bead {
    Vector position;          ///< of its centre [mm], not wrapped into a periodic cell
    Vector velocity;          ///< [mm/s]
    Vector spin;              ///< angular velocity [rad/s]
    std::uint32_t shape = 0;  ///< of Bodies::shapes
};

struct Rod {
    Vector position;             ///< of its centre of mass [mm], not wrapped
    Vector velocity;             ///< [mm/s]
    Vector axis{1.0, 0.0, 0.0};  ///< n, from tail to head; a World makes its length 1
    Vector angular_momentum;     ///< [mg mm^2/s]
    std::uint32_t shape = 0;     ///< of Bodies::shapes
};

/// Bodies keep their indices in these lists throughout a run.
struct Bodies {
    std::vector<Shape> shapes;
    std::vector<Bead> beads;
    std::vector<Rod> rods;
    /// Number of the first kick of each rod among those of the seed, a multiple of 32: bodies of another run do not
    /// repeat its kicks.
    std::int64_t first_kick = 0;
};

/// The bodies that a setup asks for, at rest at the origin; a packing places them.  The diameters of a mixture are
/// distributed in their proportions, rounded by largest remainders; the sizes of rods are drawn from the seed.  Throws
/// an input Error for an impossible shape; check(setup) finds other errors.
Bodies make_bodies(const Setup& setup, std::uint64_t seed, const Locate& locate = no_location);

/// The shapes of these bodies, rods at their mean size.
std::vector<Shape> shapes_of(const Setup& setup, const Locate& locate = no_location);

/// Area of the cell in the plane [mm^2].
double area(const Cell& cell);

}  // namespace drover::dem
