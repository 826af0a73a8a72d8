// numerics/fields/planner_memory.hpp: what FFTW makes of a failed allocation.
#pragma once
#include <cstddef>

namespace drover::numerics {

/// Memory set aside for the FFTW planner, which ends the process where an allocation fails: while this object lives,
/// such allocations in this thread take from it.  Elsewhere in FFTW a failed allocation throws std::bad_alloc.  One at
/// a time.  Without effect in a process that had loaded FFTW's library before this one.
class PlannerMemory {
public:
    /// For lines of this length.  Throws std::bad_alloc.
    explicit PlannerMemory(std::size_t length);
    ~PlannerMemory();
    PlannerMemory(const PlannerMemory&) = delete;
    PlannerMemory& operator=(const PlannerMemory&) = delete;

    /// Whether an allocation has failed.
    bool was_short() const;
};

}  // namespace drover::numerics
