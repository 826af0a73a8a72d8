// measure/path_summary.hpp: results from the paths of rods and beads: speed along n, rotational diffusion, bead
// diffusion.
#pragma once
#include <span>
#include <vector>

#include "measure/summary.hpp"
#include "measure/trajectories.hpp"

namespace drover::measure {

/// At most this many of the beads are followed, chosen evenly from their list.
inline constexpr std::size_t max_beads_followed = 2000;

/// Paths of all rods; of the beads, which are many, only squared displacements from frame to frame, summed as frames
/// come.
struct Paths {
    double spacing = 0.0;                     ///< between frames: the frame time [s]
    std::size_t frames = 0, added = 0;        ///< expected, and added so far
    std::vector<std::vector<double>> angles;  ///< of each rod, direction of n in the plane from x [rad]
    std::vector<Path> rods;                   ///< centres of mass, not wrapped [mm]
    std::vector<std::size_t> followed;        ///< indices of the beads followed
    std::vector<double> previous;             ///< their x and y in the previous frame [mm]
    GroupSums of_beads{0, 1};                 ///< squared displacements of each [mm^2]
    std::vector<double> of_frames;            ///< their mean over each frame [mm^2]
};

/// Throws an input Error unless the spacing is positive.
Paths make_paths(double spacing, std::size_t frames, std::size_t rods, std::size_t beads);

/// Adds the next frame: x, y and z of each body, and of the axis of each rod.  Throws an input Error when the number of
/// bodies changes, and for more frames than expected.
void add_frame(Paths& paths, std::span<const double> rod_position, std::span<const double> rod_axis,
               std::span<const double> bead_position);

/// The rows, with errors as in measure/trajectories.hpp:
///   rod_speed [mm/s], Speeds::mean over one frame;  rod_speed_deviation, of the means of rods (two or more; an error
///   from three on);
///   rod_head_first_fraction, the fraction of rods with a positive mean speed along n;
///   rotational_diffusion [rad2/s] and relaxation_time [s], its inverse;
///   bead_displacement_squared [mm2], over one frame; without an error where the frames are too few for one over time.
/// With fewer than two frames all are NaN, and `why_no_error` gives the reason.
std::vector<SummaryRow> path_rows(const Paths& paths);

/// C(T) = <cos of the turn of a rod from one frame to the next>; NaN without two frames of rods.
double persistence(const Paths& paths);

}  // namespace drover::measure
