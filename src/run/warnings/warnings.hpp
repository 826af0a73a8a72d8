// run/warnings/warnings.hpp: what a run cannot be trusted in, from its scene and what its archive has recorded.
#pragma once
#include <string>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "files/archive_reader.hpp"
#include "io/scene.hpp"
#include "measure/summary.hpp"
#include "measure/trajectories.hpp"
#include "model/field_evolution.hpp"

namespace drover::run {

/// A field is resolved while modes beyond two thirds of the cut hold less than this fraction of its variance.  Without
/// noise the relative error of the longest waves is then below 1 %: it was 3 to 5 times the tail for steepening waves
/// on 32 to 128 points.
inline constexpr double max_spectral_tail = 1e-3;
/// With noise the tail is physical where the noise is white: it must exceed the linear prediction by this factor as
/// well.  Nonlinear terms change the spectrum of a resolved flock by less.
inline constexpr double max_tail_over_linear = 3.0;

/// Each warning names the key of the scene and a value that would do.

/// What is known before a run.  what: its equations.
std::vector<std::string> field_scene_warnings(const io::Scene& scene, const model::Integrated& what);

/// Those, and what its archive shows.  Every reader of an archive gets the same: a run,
/// a restart, drover info.
std::vector<std::string> field_warnings(const files::ArchiveReader& archive, const io::Scene& scene,
                                        const model::Integrated& what);

/// Whether terms are functions of the calling program, which may fail where a run does not ask them.
bool calls_program(const io::Scene& scene);
/// Whether a run starts in a uniform stationary state, and has no noise.
bool stays_at_start(const io::Scene& scene, const model::Equations& equations);

// ---- Resolution

/// Whether the steps of a scene see its terms of t: they are compared with a finer sampling, also about each time that
/// the formulas name.  True where that is not known.  model: of the equations of the scene.
bool resolves_time(const io::Scene& scene, const model::Model& model);
/// Of the terms written as text.  Those of x and y are compared with their values on twice the grid, those of t with a
/// finer sampling of the time between steps, both at a smooth state; of a long run in windows of time.
std::vector<std::string> text_resolution_warnings(const io::Scene& scene, const model::Model& model);

// Whether a grid keeps the waves that grow about the references of equations, of a system of these.  Where a term
// depends on position or time, or has no derivative at the references, its linear part stands for theirs.

/// The largest wavenumber up to `max_q` whose waves grow, in any direction; 0: none.  max_q: that of the grid.
double largest_growing(const model::Equations& equations, const numerics::System& system, double max_q);
/// The warning of a grid that cuts waves which grow, with a grid that keeps them; "" where it keeps them all.
std::string growing_waves_warning(const model::Equations& equations, const numerics::System& system,
                                  const io::Units& units);
/// "grid.nx = 64 and grid.ny = 32", or "grid.nx = 64" of a grid of one row; with `factor` times the points.
std::string grid_keys(const numerics::Grid& grid, int factor = 1);

// ---- Of what an archive shows

/// Negative densities, and values beyond a table.
void add_density_warnings(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                          std::vector<std::string>& warnings);
/// Order that has not grown yet.
void add_late_order(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                    std::vector<std::string>& warnings);

/// The recorded values of an observable of a run of fields; empty in archives without it.
std::vector<double> series_of(const files::ArchiveReader& archive, const std::string& name);

// ---- Of runs of particles

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
