// run/wave_fit.hpp: coefficients of the field equations from the frames of a run, as a result.
#pragma once
#include <string>
#include <vector>

#include "drover/io/scene.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

struct WaveFitOptions {
    std::string archive;                       ///< of a run of fields or, in a periodic cell, of particles
    std::vector<std::string> keys;             ///< numbers of the model to fit
    std::string scene = {};                    ///< the model; "": that of the archive, which is then one of fields
    std::vector<std::string> overrides = {};   ///< of that scene: starting values, and values that are not fitted
    double max_wavenumber = 0.0;               ///< |q| [1/mm]; 0: three times the smallest of the cell
    double begin = 0.0;                        ///< of the frames used [s]
    double end = 0.0;                          ///< the same; 0: the last
    int every = 1;                             ///< frames from one used to the next
};

/// Fits the linear equations about the uniform state of these frames, without order or with that of a flock.  Fields
/// of particles are sums over bodies; the velocity of a body is its displacement from the frame before to the frame
/// after over the time between them.  Throws an input Error for an archive without such frames, frames whose order is
/// neither that of a flock nor gone in their mean, and as calibrate::fit_waves.
Result make_wave_fit(const WaveFitOptions& options);

}  // namespace drover::run
