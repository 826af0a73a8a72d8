// measure/trajectories.hpp: observables of the paths of bodies: rotational correlation and diffusion, speeds of rods;
// the results of a run from them, with bead diffusion; and errors by the jackknife over independent groups of values.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "base/constants.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::measure {

/// Sums of values and their numbers, [group][quantity].
struct GroupSums {
    std::vector<std::vector<double>> sums, counts;
    GroupSums(std::size_t groups, std::size_t quantities)
        : sums(groups, std::vector<double>(quantities)), counts(groups, std::vector<double>(quantities)) {}
    void add(std::size_t group, std::size_t quantity, double value) {
        sums[group][quantity] += value;
        counts[group][quantity] += 1.0;
    }
};

/// `function` of the means of the quantities over all groups.  Empty groups are left out.
Estimate jackknife(const GroupSums& group_sums, const std::function<double(std::span<const double> means)>& function);

/// Positions of one body in the plane at equal times, not wrapped [mm].
struct Path {
    std::vector<double> x, y;
};

/// C(t) = <cos(theta(t0 + t) - theta(t0))> over all rods and all origins t0.
struct RotationalCorrelation {
    std::vector<double> times;     ///< 0, spacing, 2 spacing, ... [s]
    std::vector<Estimate> values;  ///< C at these
    GroupSums groups{0, 0};        ///< [group][lag], for fits
    double segment_time = 0.0;     ///< of origins in the shortest group [s]
    bool by_time = false;          ///< groups are segments of time
};
/// Angles of each rod [rod][time], wrapped or not, of any lengths (one rod started many times counts as many rods);
/// lags 0 to max_lags, or to the longest available.
RotationalCorrelation rotational_correlation(std::span<const std::vector<double>> angles, double spacing,
                                             std::size_t max_lags);

/// C(t) is fitted up to the last lag before -ln C exceeds this, or the last of all, and from an eighth of that one on.
inline constexpr double fitted_drop = 0.5;

/// Rotational diffusion, from C(t) = c exp(-D_r t).
struct RotationalDiffusion {
    Estimate diffusion;        ///< D_r [1/s]
    Estimate relaxation_time;  ///< 1/D_r [s]; its mean is 1/D_r, its error is propagated from D_r
    double fast = 0.0;         ///< 1 - c: the initial loss of C, by jitter of the angle that does not accumulate
    double to = 0.0;           ///< largest lag fitted [s]
};
/// 1/D_r with its error; infinite and without an error where D_r <= 0.
Estimate relaxation_time_of(const Estimate& diffusion);
/// Straight line through -ln C(t) by least squares, weights 1/t^2.  An angle diffuses at times longer than the memory
/// of the angular velocity, and the error of C(t) grows with t: few segments of that length are independent, so values
/// at long times follow those at short ones.  Hence the fit to the early decay of C, weighted to its start, with an
/// intercept for the initial loss.  The error is that of the slope under the jackknife over groups; there is none when
/// groups are segments of time shorter than 3/D_r.
RotationalDiffusion rotational_diffusion(const RotationalCorrelation& correlation);

/// Speeds of rods along themselves, d.n(t0)/T, d the displacement from t0 over a frame of length T.
struct Speeds {
    Estimate mean;                ///< over rods and frames [mm/s]
    std::vector<double> of_rods;  ///< mean of each rod [mm/s]
    /// Of these means, over the error of each in time; about 1 where rods are alike; NaN with fewer than four errors.
    double scatter = nan;
};
/// Of consecutive frames.  The frame of the experiment is 1/40 s.  A rod with speed v and rotational diffusion D_r has
/// the mean v (1 - exp(-D_r T))/(D_r T).
Speeds speeds_along(std::span<const Path> rods, std::span<const std::vector<double>> angles, double spacing);

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

/// The rows, with errors as above:
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
