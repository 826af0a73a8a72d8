// run/boundary_plan.hpp: the plane, the uncertain numbers and the conventions of drover boundary, read from a scene.
#pragma once
#include <string>
#include <vector>

#include "drover/io/scene.hpp"
#include "drover/physics/phase_boundary.hpp"

namespace drover::run {

struct PlannedBoundary {
    physics::Plane plane;
    std::vector<physics::Uncertain> uncertain;  ///< beside those from a table of calibrated.table
    std::vector<std::string> conventions;       ///< of lambda: at least one
    std::vector<physics::Limit> limits;
    bool has_binodal = false;  ///< with it or a limit
};

/// The lines that a plane may show, which are the choices of boundary.lines: the limits, and the binodals of phases
/// that coexist.
const std::vector<std::string>& line_names();
inline constexpr const char* binodal_name = "binodal";

/// "key = from:to", an axis of a plane.
struct KeyRange {
    std::string key;
    double from = 0.0, to = 1.0;
};

/// The axis that the scene's key `list` gives; messages quote `example`.  Throws an input Error at `where`.
KeyRange read_axis(const std::string& list, const std::string& written, const std::string& example,
                   const SourceLocation& where);

/// Throws an input Error at the key that is wrong.
PlannedBoundary plan_boundary(const io::Scene& scene);

}  // namespace drover::run
