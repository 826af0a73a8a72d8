// analysis/wave_fit.hpp: coefficients of the field equations from the frames of a run, as a result.
#pragma once
#include <string>
#include <vector>

#include "analysis/wave_record.hpp"
#include "run/result.hpp"

namespace drover::analysis {

/// The model to fit, with starting values and those that are not fitted: the scene in `file` or, if it is "", that of
/// the archive, which is then one of fields; with overrides "section.key=value".
io::Scene fitted_scene(const std::string& archive, const std::string& file, const std::vector<std::string>& overrides);

struct WaveFitOptions {
    std::string archive;            ///< of a run of fields or, in a periodic cell, of particles
    std::vector<std::string> keys;  ///< numbers of the model to fit
    WaveChoice choice = {};         ///< waves that the run kept; with a largest |q| below the smallest means alone
};

/// Fits the linear equations about the uniform state of these frames, without order or with that of a flock.  The noise
/// is that of the model if one of its strengths is fitted, else any (calibrate::NoiseOf::frames).  Fields
/// of particles are sums over bodies; the velocity of a bead is its displacement from the frame before to the frame
/// after over the time between them.  Throws an input Error for an archive without such frames, for frames whose mean
/// order is neither that of a flock nor gone, and as calibrate::fit_waves.
run::Result make_wave_fit(const io::Scene& scene, const WaveFitOptions& options);

}  // namespace drover::analysis
