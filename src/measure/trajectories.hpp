// measure/trajectories.hpp: observables of the paths of bodies: rotational correlation and diffusion, speeds of rods.
#pragma once
#include <span>
#include <vector>

#include "base/constants.hpp"
#include "drover/measure/statistics.hpp"
#include "measure/jackknife.hpp"

namespace drover::measure {

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

/// The range of lags over which C(t) is fitted.
struct RotationFit {
    double from =
        0.0;          ///< smallest lag [s], longer than the memory of the angular velocity; 0: an eighth of the largest
    double to = 0.0;  ///< largest lag [s]; 0: found from `drop`
    double drop = 0.5;  ///< the largest lag is the last before -ln C exceeds this, or the last of all
};

/// Rotational diffusion, from C(t) = c exp(-D_r t).
struct RotationalDiffusion {
    Estimate diffusion;           ///< D_r [1/s]
    Estimate relaxation_time;     ///< 1/D_r [s]; its mean is 1/D_r, its error is propagated from D_r
    double fast = 0.0;            ///< 1 - c: the initial loss of C, by jitter of the angle that does not accumulate
    double from = 0.0, to = 0.0;  ///< lags fitted [s]
    std::size_t lags = 0;
};
/// 1/D_r with its error; infinite and without an error where D_r <= 0.
Estimate relaxation_time_of(const Estimate& diffusion);
/// Straight line through -ln C(t) by least squares, weights 1/t^2.  An angle diffuses at times longer than the memory
/// of the angular velocity, and the error of C(t) grows with t: few segments of that length are independent, so values
/// at long times follow those at short ones.  Hence the fit to the early decay of C, weighted to its start, with an
/// intercept for the initial loss.  The error is that of the slope under the jackknife over groups; there is none when
/// groups are segments of time shorter than 3/D_r.
RotationalDiffusion rotational_diffusion(const RotationalCorrelation& correlation, const RotationFit& fit = {});

/// The mean of one quantity over bodies, groups, and over time, the samples: bodies keep their differences, such as
/// their gaits, and what they do together does not average out over them.  The error is the larger of both; that over
/// bodies alone where the samples are too short for one.
Estimate with_error_over_time(const GroupSums& groups, const Samples& samples);

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

}  // namespace drover::measure
