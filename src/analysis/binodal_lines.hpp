// analysis/binodal_lines.hpp: the densities of coexisting phases as lines of a plane.
#pragma once
#include "analysis/boundary_plan.hpp"

namespace drover::analysis {

struct BinodalLines {
    theory::Boundary boundary;
    std::vector<std::string> ends;  ///< why lines end within the plane
};

/// The binodal of each phase: from the state of two phases next to the initial fields of the scene, along the other
/// axis of the plane to both its ends.  convention: of lambda; "": none.  Throws a run Error where no such state is
/// found.
BinodalLines trace_binodal_lines(const io::Scene& scene, const PlannedBoundary& planned, const std::string& convention,
                                 Threads& threads);

}  // namespace drover::analysis
