// analysis/boundary_problem.hpp: what drover boundary needs of a kind of scene.
#pragma once
#include <functional>
#include <vector>

#include "analysis/binodal_lines.hpp"
#include "analysis/boundary_plan.hpp"

namespace drover::analysis {

/// Lines of one kind.
struct PlaneLines {
    DescribedLines described;
    std::function<theory::PlaneMargins()> margins = {};           ///< which vanish on them
    std::function<BinodalLines(Threads& threads)> binodals = {};  ///< in place of margins
};

struct BoundaryProblem {
    std::size_t draws = 0;  ///< of numbers with errors
    std::vector<PlaneLines> lines = {};
    std::vector<files::Quantity> map = {};  ///< numbers of a point
    std::function<std::vector<double>(const numerics::PlanePoint&)> map_at = {};
};

/// quiet: else progress is shown where it takes minutes.  Its margins throw an environment Error on a stop signal.
BoundaryProblem boundary_problem(const io::Scene& scene, const PlannedBoundary& planned, bool quiet);

}  // namespace drover::analysis
