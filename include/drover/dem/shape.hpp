// dem/shape.hpp: rigid bodies of revolution: the union of spheres whose centres lie on one axis, as one solid.
#pragma once
#include <vector>

#include "drover/base/error.hpp"

namespace drover::dem {

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
/// gives a ball.
Shape make_rod(const std::vector<double>& diameters, double length, double density, const SourceLocation& where = {});

Shape make_ball(double diameter, double density, const SourceLocation& where = {});

}  // namespace drover::dem
