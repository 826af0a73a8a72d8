// run/particle_warnings.hpp: what the results of a run of particles cannot be trusted in.
#pragma once
#include <string>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "drover/dem/setup.hpp"
#include "io/scene.hpp"
#include "measure/path_summary.hpp"

namespace drover::run {

/// Plates whose motion is far from what the sizes of the bodies and gravity allow, as numbers in other units have it.
std::vector<std::string> unit_warnings(const dem::Setup& setup);

/// Absorbing states (bodies at rest, or all in step with each other) and energy gained in impacts.  `spacing`: of the
/// samples [s].
std::vector<std::string> particle_state_warnings(const io::Scene& scene, const dem::Bodies& bodies,
                                                 const std::vector<measure::RecordedSeries>& series, double spacing);

/// Rods whose means differ by more than each changes in time.
std::vector<std::string> scatter_warnings(const measure::Paths& paths);

/// Rods that turn so much between frames that rod_speed is no longer their speed along n.
std::vector<std::string> frame_warnings(const measure::Paths& paths);

}  // namespace drover::run
