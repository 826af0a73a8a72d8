// numerics/steppers/effort.hpp: the work of a run, and what estimates of its errors may take of it.
#pragma once
#include <cmath>

#include "drover/numerics/grid.hpp"

namespace drover::numerics {

/// What a run does, in instructions: counted, not timed, so that results are the same on every machine.
struct StepWork {
    double rate = 1e6;          ///< a right-hand side
    double rate_a_point = 0.0;  ///< that of other grids, for each of weighed_points()
    double noise = 0.0;         ///< of a step
    double observing = 0.0;     ///< of each dt
};

/// Of equations: components of a state, those that noise drives, and transforms of a right-hand side.
struct WorkCounts {
    int components = 1, noisy = 0, inverse = 0, forward = 0;
};
StepWork step_work(const Grid& grid, const WorkCounts& counts);

/// The work of the observables of a state with so many components, once.
double work_of_observing(const Grid& grid, int components);

/// The points of a grid as transforms of them cost: lengths with a factor 3 or 5 cost more than powers of 2.
double weighed_points(const Grid& grid);

/// A part of the work of a run.
struct Effort {
    double part = INFINITY;  ///< of a run above 10 s; twice as much up to 3.3 s, falling in between
    double done = 0.0;       ///< by the run so far, without what estimates take
    double spent = 0.0;      ///< on estimates so far

    double allowed() const { return allowed(done); }
    /// When the run will have done so much.
    double allowed(double work) const;
    /// By which that grows with so much work.
    double gain(double work) const { return allowed(done + work) - allowed(); }
    bool affords(double work) const { return spent + work <= allowed(); }
    /// What was spent, in parts of what is allowed.
    double used() const { return std::isinf(part) ? 0.0 : spent / allowed(); }
};

/// What may be owed, since errors change fastest at the start.
double owed_work();

}  // namespace drover::numerics
