// analysis/wave_problem.hpp: what drover fit fits: the waves of frames, and the equations about the state of their
// means.
#pragma once
#include <string>
#include <vector>

#include "analysis/wave_record.hpp"
#include "run/result.hpp"

namespace drover::analysis {

struct WaveProblem {
    calibrate::WaveRecord record;
    calibrate::WaveModel waves;
    calibrate::NoiseOf noise = calibrate::NoiseOf::frames;
    std::vector<std::string> units;  ///< of the numbers
    std::string about;               ///< "an ordered state": the uniform state of the waves
    std::vector<run::Entry> state;   ///< its values
};

/// An archive of frames, what messages call it, and its scene.
struct FrameSource {
    const files::ArchiveReader& archive;
    std::string name;
    const io::Scene& scene;
};

/// The numbers that `keys` name of the equations of a scene, which may be another one than that of the frames with the
/// same fields.  Throws as make_wave_fit.
WaveProblem wave_problem(const io::Scene& scene, const std::vector<std::string>& keys, const WaveChoice& choice,
                         const FrameSource& source);

}  // namespace drover::analysis
