// analysis/boundary.hpp: phase boundaries in a plane of two numbers of a scene's model.
#pragma once
#include "base/compute_all.hpp"
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::analysis {

/// Who computes the lines of a plane, and how much of it.
struct BoundaryWork {
    ComputeAll compute = {};  ///< of the lines and their errors; empty: the threads
    bool lines_alone = false;
    bool quiet = true;  ///< else progress is shown where it takes minutes
};

/// The lines of each limit and convention of lambda; in an archive the plane, the vertices of all lines and the map of
/// regimes.  Throws an input Error, at boundary.x, .y, .lines, .conventions or .errors, for a plane that cannot be
/// traced, and for a model of its own an environment Error on a stop signal.
run::Result make_boundary(const io::Scene& scene, Threads& threads, const BoundaryWork& work = {});

/// Throws the same input Errors for the plane of a scene, if it has one, without tracing it.
void check_boundary(const io::Scene& scene);

}  // namespace drover::analysis
