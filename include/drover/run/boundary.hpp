// run/boundary.hpp: what drover boundary traces: lines of lost stability in a plane of two numbers of a scene's model.
#pragma once
#include <string>
#include <vector>

#include "drover/files/archive.hpp"
#include "drover/io/scene.hpp"
#include "drover/physics/phase_boundary.hpp"

namespace drover::run {

/// Lines of one kind, for one convention of lambda.
struct TracedLines {
    physics::Limit limit = physics::Limit::onset;
    std::string convention;  ///< of weathercock.strength: mean or single-rod
    physics::Boundary boundary;
};

/// Which uniform state a point of the plane has, and whether long waves grow on it.
enum class Regime { none = -1, isotropic = 0, separating = 1, flock = 2, banding = 3, oblique = 4 };

struct BoundaryReport {
    io::Scene scene;
    physics::PlaneAxis x, y;
    std::vector<TracedLines> traced;
    std::size_t uncertain = 0;                 ///< numbers with a standard error
    std::vector<double> map_x, map_y;          ///< of the map, for the first convention
    std::vector<Regime> regimes;               ///< [y][x]
    std::vector<double> effective_relaxation;  ///< abar, [y][x]; not-a-number beyond a table
};

/// Throws input Errors at the place of boundary.x, .y, .errors for what is no plane.
BoundaryReport make_boundary(const io::Scene& scene, Threads& threads);

/// For people: each line with some of its points.
std::string boundary_text(const BoundaryReport& report);

/// The plane, the vertices of all lines where there are any, and the map.
std::vector<files::ResultTable> boundary_tables(const BoundaryReport& report);

}  // namespace drover::run
