// dem/contact/pair_impacts.hpp: impulses of spheres that overlap each other or a side wall at the end of a step.
#pragma once
#include <cstdint>
#include <vector>

#include "dem/contact/contact_report.hpp"
#include "dem/flight/step_rules.hpp"
#include "dem/neighbours/neighbours.hpp"
#include "drover/base/threads.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

/// Reuses its memory from step to step.
class PairImpacts {
public:
    /// Finds all overlaps, resolves each group in which a contact approaches, and corrects positions for the time since
    /// first contact. Returns the contributions of this step to the energy balance and the counts, and its deepest
    /// overlap.
    ContactReport step(const Walls& walls, Spheres& spheres, const Neighbours& neighbours, const StepRules& rules,
                       Threads& threads);

private:
    void group(const std::vector<Overlap>& overlaps, std::size_t bodies);

    OverlapSearch search_;
    std::vector<std::uint32_t> last_;  // of each body: its latest overlap in this step
    std::vector<std::uint32_t> parent_, size_, order_, start_;
    std::vector<ContactReport> reports_;
};

}  // namespace drover::dem
