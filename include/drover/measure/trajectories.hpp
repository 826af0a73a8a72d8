// measure/trajectories.hpp: what is measured on the paths of bodies: rotational correlation and diffusion, speeds, mean-square displacement.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::measure {

/// Places of one body in the plane at equal times, not wrapped [mm].
struct Path {
    std::vector<double> x, y;
};

/// Bodies followed at equal times.
struct Trajectory {
    double spacing = 0.0;  ///< between snapshots [s]; 0 until there are two
    std::size_t snapshots = 0;
    std::size_t beads_in_all = 0;
    double start = 0.0;                       ///< time of the first [s]
    std::vector<std::vector<double>> angles;  ///< of each rod, direction of n in the plane from x [rad]
    std::vector<Path> rods;                   ///< centres of mass
    std::vector<std::size_t> followed;        ///< which beads
    std::vector<Path> beads;                  ///< centres of these
};

/// Follows all rods and at most this many of the beads, spread over their list.
inline constexpr std::size_t max_beads_followed = 2000;

/// Adds a snapshot.  Throws an input Error when the times are not equally spaced (to 1e-6 of the spacing) or the number of bodies changed.
void add_snapshot(Trajectory& trajectory, double time, const dem::Bodies& bodies);

/// Errors here come from units taken as independent: bodies when there are min_units or more of them, else stretches of time of each body, at
/// least min_units altogether.  In a flock rods are not independent: such errors are too small there; use runs of different seeds.  Each
/// estimate is the jackknife over units; `blocks` is their number: (mean - truth)/error is Student's t of blocks - 1 degrees.  No error, and a
/// refusal, when there are fewer than two units.
inline constexpr std::size_t min_units = 16;

/// C(t) = <cos(theta(t0 + t) - theta(t0))> over all rods and all origins t0.
struct RotationalCorrelation {
    std::vector<double> times;                      ///< 0, spacing, 2 spacing, ... [s]
    std::vector<Estimate> values;                   ///< C at these
    std::vector<std::vector<double>> sums, counts;  ///< [unit][lag], for fits
    double unit_time = 0.0;                         ///< of origins in the shortest unit [s]
    bool by_time = false;                           ///< units are stretches of time
};
/// Angles of each rod [rod][time], wrapped or not, of any lengths (a rod alone, started many times, is as many rods); lags 0 to max_lags or the longest there is.
RotationalCorrelation rotational_correlation(std::span<const std::vector<double>> angles, double spacing,
                                             std::size_t max_lags);

/// Between which lags C(t) is fitted.
struct RotationFit {
    double from = 0.0;  ///< least lag [s], longer than the memory of the angular velocity; 0: an eighth of the largest
    double to = 0.0;    ///< largest lag [s]; 0: found
    double drop = 0.5;  ///< found: the last lag before -ln C exceeds this, all lags there are at most
};

/// Rotational diffusion, from C(t) = c exp(-D_r t).
struct RotationalDiffusion {
    Estimate diffusion;           ///< D_r [1/s]
    Estimate relaxation_time;     ///< 1/D_r [s]; its mean is 1/D_r, its error that of D_r carried over
    double fast = 0.0;            ///< 1 - c: what C loses at once, to jitter of the angle that does not add up
    double from = 0.0, to = 0.0;  ///< lags fitted [s]
    std::size_t lags = 0;
};
/// 1/D_r with its error; infinite, and a refusal, where D_r is not > 0.
Estimate relaxation_time_of(const Estimate& diffusion);
/// Straight line through -ln C(t) by least squares, weights 1/t^2.  An angle diffuses for times longer than the memory of the angular velocity,
/// and C(t) is known the worse the longer the time: few stretches of it are independent, so values at long times follow those at short ones.
/// Hence the early fall of C, weighted to its start, and an intercept that takes what was lost before it.  The error is that of the slope under
/// the jackknife over units; it is refused when units are stretches of time shorter than 3/D_r.
RotationalDiffusion rotational_diffusion(const RotationalCorrelation& correlation, const RotationFit& fit = {});

/// Speeds of rods along themselves, from displacements over frames.
struct Speeds {
    double frame = 0.0;             ///< frame time [s]
    Estimate along_start;           ///< mean of d.n(t0)/frame, d the displacement from t0 over a frame [mm/s]
    Estimate along_mean;            ///< the same along the mean of n over the frame, both ends at half weight [mm/s]
    double spread_of_rods = 0.0;    ///< standard deviation among rods of the mean of along_mean of each [mm/s]
    double spread_of_frames = 0.0;  ///< standard deviation of along_mean over all frames of all rods [mm/s]
    std::vector<double> of_rods, of_frames;   ///< along_mean: means of each rod; all frames, rod by rod [mm/s]
    std::vector<double> of_rods_along_start;  ///< along_start: means of each rod [mm/s]
};
/// Frames of `steps` snapshots >= 1, one after the other; the experiment's frame is 1/40 s.  A rod of speed v and rotational diffusion D_r has
/// along_start = v (1 - exp(-D_r frame))/(D_r frame) and along_mean = v (1 - D_r frame/6) for short frames.
Speeds speeds_along(std::span<const Path> rods, std::span<const std::vector<double>> angles, double spacing,
                    std::size_t steps);

/// Mean-square displacement in the plane, over bodies and origins [mm^2].
struct Displacement {
    std::vector<double> times;     ///< [s]
    std::vector<Estimate> values;  ///< <|r(t0 + t) - r(t0)|^2>
};
/// Of paths of one length.  `about_mean`: of each body beside the mean of all of them, for beads that flow.
Displacement mean_square_displacement(std::span<const Path> bodies, double spacing, std::size_t max_lags,
                                      bool about_mean = false);

/// Density of values in equal bins between the least and the largest: sum of density times width is 1.
struct Histogram {
    std::vector<double> middles, density;
    double width = 0.0;
};
Histogram histogram(std::span<const double> values, std::size_t bins);

}  // namespace drover::measure
