// analysis/wave_fit.hpp: coefficients of the field equations from the frames of a run, as a result.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calibrate/wave_fit.hpp"
#include "files/archive_reader.hpp"
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::analysis {

/// Which waves of which frames.
struct WaveChoice {
    std::optional<double> max_wavenumber = std::nullopt;  ///< |q| [1/mm]; none: three times the smallest of the cell
    double begin = 0.0;                                   ///< of the frames [s]
    std::optional<double> end = std::nullopt;             ///< of the frames [s]; none: the last
    int every = 1;                                        ///< frames from one used to the next
    io::Units units = {};                                 ///< for messages
};

/// The fields of the frames of a run, in the order of their amplitudes.
struct RecordedFields {
    struct Component {
        std::string name, unit;
    };
    numerics::Grid grid;
    int kept_degree = 1;  ///< as for numerics::is_kept
    std::vector<Component> components;
};

/// Waves of an archive of fields, among those that the run kept.  Messages call the archive `name`.  Throws an input
/// Error for frames that are missing, damaged, too few or at unequal times, and for more than 400 waves.
calibrate::WaveRecord field_waves(const files::ArchiveReader& archive, const std::string& name,
                                  const RecordedFields& recorded, const WaveChoice& choice);

/// Of the fields of a model, of an archive of particles in a periodic cell: sums over their bodies.  The velocity of a
/// bead is its displacement from the frame before to the frame after over the time between them.
calibrate::WaveRecord particle_waves(const files::ArchiveReader& archive, const std::string& name,
                                     const io::Scene& scene, const model::Model& model, const WaveChoice& choice);

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
