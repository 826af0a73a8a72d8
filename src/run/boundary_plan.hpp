// run/boundary_plan.hpp: the plane, the uncertain numbers and the lines of drover boundary, read from a scene.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "drover/io/scene.hpp"
#include "run/boundary_records.hpp"

namespace drover::run {

struct PlannedBoundary {
    DescribedAxis x, y;                                  ///< named by their keys, "driving.strength", "coefficients.a"
    std::vector<std::pair<std::string, double>> errors;  ///< standard errors by key, beside those of tables
    std::vector<std::string> conventions;                ///< of lambda: at least one; none in a model of one's own
    std::vector<std::string> lines;                      ///< at least one, binodals last
};

/// The lines that a plane may show: limits of stability of rods and beads and the binodals of phases that coexist, or
/// the uniform states of a model of one's own.
const std::vector<std::string>& line_names(io::SceneKind kind);
inline constexpr const char* binodal_name = "binodal";

/// Throws an input Error at the key that is wrong.
PlannedBoundary plan_boundary(const io::Scene& scene);

}  // namespace drover::run
