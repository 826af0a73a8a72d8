// measure/path_summary.hpp: what the paths of rods and beads say of a run: speed along n, gait, loss of direction, spread of beads.
#pragma once
#include <span>
#include <vector>

#include "drover/measure/summary.hpp"
#include "drover/measure/trajectories.hpp"

namespace drover::measure {

/// Paths of all rods, and of beads their displacements from frame to frame alone, summed as frames come: beads are many.
struct Paths {
    double spacing = 0.0;                           ///< between frames: the frame time [s]
    std::size_t frames = 0, added = 0;              ///< that will come, and that came
    std::vector<std::vector<double>> angles;        ///< of each rod, direction of n in the plane from x [rad]
    std::vector<Path> rods;                         ///< centres of mass, not wrapped [mm]
    std::vector<std::size_t> followed;              ///< which beads, at most max_beads_followed
    std::vector<double> before;                     ///< x and y of these in the frame before [mm]
    std::vector<std::vector<double>> sums, counts;  ///< [unit][1] of squared displacements [mm^2]
};

/// For so many frames of so many bodies.  Throws an input Error unless the spacing is positive.
Paths make_paths(double spacing, std::size_t frames, std::size_t rods, std::size_t beads);

/// Adds the next frame: x, y and z of each body, and of the axis of each rod.  Throws an input Error for other numbers of bodies than before,
/// and for more frames than were to come.
void add_frame(Paths& paths, std::span<const double> rod_position, std::span<const double> rod_axis,
               std::span<const double> bead_position);

/// The rows, with the errors and refusals of measure/trajectories.hpp:
///   rod_speed [mm/s], Speeds::along_start over one frame;  rod_speed_deviation, of its means of each rod (two rods or more);
///   rod_speed_ahead_share, the share of rods whose mean is > 0: of rods with two gaits, how many go ahead;
///   rotational_diffusion [rad2/s] and relaxation_time [s], its inverse;
///   bead_displacement_squared [mm2], over one frame.
/// All are not-a-number, with a sentence, where fewer than two frames came.
std::vector<SummaryRow> path_rows(const Paths& paths);

}  // namespace drover::measure
