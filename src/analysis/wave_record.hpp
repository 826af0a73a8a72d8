// analysis/wave_record.hpp: waves of the frames of a run.
#pragma once
#include <optional>

#include "calibrate/wave_fit.hpp"
#include "files/archive_reader.hpp"
#include "io/scene.hpp"

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

}  // namespace drover::analysis
