// analysis/boundary_work.hpp: who computes the lines of a plane, and how much of it.
#pragma once
#include "base/compute_all.hpp"

namespace drover::analysis {

struct BoundaryWork {
    ComputeAll compute = {};  ///< of the lines and their errors; empty: the threads
    bool lines_alone = false;
    bool quiet = true;  ///< else progress is shown where it takes minutes
};

inline ComputeAll compute_of(const BoundaryWork& work, Threads& threads) {
    return work.compute ? work.compute : on_threads(threads);
}

}  // namespace drover::analysis
