// numerics/effort.hpp: what estimates of errors may take of the time of a run.
#pragma once
#include <cmath>

#include "drover/numerics/grid.hpp"

namespace drover::numerics {

/// A part of the time of a run, counted in its steps.  Work is counted, not timed, so that results are the same on
/// every machine; its constants are instructions, measured.
struct Effort {
    double part = INFINITY;    ///< of the time of a run above 10 s; of a shorter one twice as much
    double work_a_step = 1e6;  ///< see work_of_right_hand_side()
    double spent = 0.0;        ///< so far, in steps

    double seconds_a_step() const;
    /// That of this many steps, in steps.
    double allowed(double steps) const;
    /// What may be owed, since errors change fastest at the start, in steps.
    double credit() const;
    bool affords(double cost, double steps) const { return spent + cost <= allowed(steps); }
    /// What was spent, in parts of what is allowed.
    double used(double steps) const { return std::isinf(part) ? 0.0 : spent / allowed(steps); }
};

/// The points of a grid as transforms of them cost: lengths with a factor 3 or 5 cost more than powers of 2.
double weighed_points(const Grid& grid);

/// The work of a right-hand side with so many transforms, and of what a step makes of it.
double work_of_right_hand_side(const Grid& grid, int components, int inverse, int forward);

}  // namespace drover::numerics
