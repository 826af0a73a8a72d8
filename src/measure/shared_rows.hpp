// measure/shared_rows.hpp: the observables that fields and particles share: one name, one formula, one function.
#pragma once
#include <cmath>
#include <span>
#include <string>

#include "measure/observable.hpp"

namespace drover::measure {

/// A mean over bodies, (x, y)/weight.
struct MeanVector {
    double x = 0.0, y = 0.0, weight = 1.0;
};
inline double size_of(const MeanVector& mean) { return std::hypot(mean.x, mean.y) / mean.weight; }

// Each kind of moment defines the means over bodies from which the shared observables follow.  Fields weight each point
// by the number density of the bodies, where that is a field:
//   MeanVector mean_direction(moment);      <n>, over the rods
//   MeanVector mean_velocity(moment);       <v>, over the beads [mm/s]
//   double mean_square_velocity(moment);    <v^2>, over the beads [mm^2/s^2]

/// 1 when all beads have the same velocity, 0 when all are at rest.
template <class Moment>
double order_of_velocity(const Moment& moment) {
    const double square = mean_square_velocity(moment);
    return square > 0.0 ? size_of(mean_velocity(moment)) / std::sqrt(square) : 0.0;
}

/// Cosine of the angle between <v> of the beads and <n> of the rods; NaN when either is zero.
template <class Moment>
double flow_alignment(const Moment& moment) {
    const MeanVector v = mean_velocity(moment), n = mean_direction(moment);
    return (v.x * n.x + v.y * n.y) / (std::hypot(v.x, v.y) * std::hypot(n.x, n.y));
}

/// What the observables of the order of rods and of the velocity of beads begin with; "": there are none.
struct SharedNames {
    std::string order, flow;
};

/// The rows of a cell with rods, with moving beads, or with both.
template <class Moment>
void add_shared(const SharedNames& names, Observables<Moment>& rows) {
    if (!names.order.empty())
        add(rows, names.order, "1",
            "polar order P = |<n>|, mean over the rods of n, their direction in the plane from tail to head",
            [](const Moment& moment) { return size_of(mean_direction(moment)); });
    if (names.flow.empty()) return;
    add(rows, names.flow + "_mean_x", "mm s-1", "mean over the beads of their velocity along x, <v_x>",
        [](const Moment& moment) { return mean_velocity(moment).x / mean_velocity(moment).weight; });
    add(rows, names.flow + "_mean_y", "mm s-1", "mean over the beads of their velocity along y, <v_y>",
        [](const Moment& moment) { return mean_velocity(moment).y / mean_velocity(moment).weight; });
    add(rows, "bead_speed", "mm s-1", "root mean square over the beads of their velocity in the plane, sqrt(<v^2>)",
        [](const Moment& moment) { return std::sqrt(mean_square_velocity(moment)); });
    add(rows, names.flow + "_order", "1",
        "order of the bead velocity in the plane, |<v>|/sqrt(<v^2>), means over the beads; 0 when all are at rest",
        order_of_velocity<Moment>);
    if (!names.order.empty())
        add(rows, "flow_alignment", "1",
            "cosine of the angle between the mean velocity of the beads and the mean direction of the rods, "
            "<v>.<n>/(|<v>| |<n>|); NaN when either mean is zero",
            flow_alignment<Moment>);
}

/// The variance of the number of bodies in boxes.
template <class Moment>
void add_number_variance(Observables<Moment>& rows, const std::string& what, const std::string& ending,
                         const std::string& shape, Axis axis, ArrayOf<Moment> function) {
    add(rows, what + "_number_variance" + ending, "1", {std::move(axis)},
        "variance of the number of " + what + "s in a " + shape +
            ", DN^2: over all positions of the box on a periodic mesh at one time; N (1 - f) for bodies at random, f "
            "the area of the box over that of the cell",
        std::move(function));
}

/// The axis of boxes of n by n cells of a mesh.
inline Axis box_axis(std::span<const int> sides, double cell_area) {
    Axis axis{"box_side", "mm", "side of a square with the area of the box", {}};
    for (const int cells : sides) axis.values.push_back(cells * std::sqrt(cell_area));
    return axis;
}

}  // namespace drover::measure
