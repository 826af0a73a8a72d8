// run/binodal_lines.hpp: the densities of coexisting phases as lines of a plane.
#pragma once
#include "drover/io/scene.hpp"
#include "drover/physics/phase_boundary.hpp"

namespace drover::run {

struct BinodalLines {
    model::Boundary boundary;
    std::vector<std::string> ends;  ///< why lines end within the plane
};

/// The binodal of each phase: from the state of two phases next to the initial fields of the scene, along the other
/// axis of the plane to both its ends.  `plane`: of this scene, its model in the convention of the line.  Throws a run
/// Error where no such state is found.
BinodalLines trace_binodal_lines(const io::Scene& scene, const physics::Plane& plane, Threads& threads);

/// Throws an input Error where no axis of the plane is the density of a field.
void check_binodal_plane(const io::Scene& scene, const std::string& x, const std::string& y);

}  // namespace drover::run
