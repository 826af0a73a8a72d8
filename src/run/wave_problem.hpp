// run/wave_problem.hpp: what drover fit fits, of rods and beads or of a declared model.
#pragma once
#include <string>
#include <vector>

#include "drover/run/result.hpp"
#include "run/wave_record.hpp"

namespace drover::run {

struct WaveProblem {
    calibrate::WaveRecord record;
    calibrate::WaveModel waves;
    calibrate::NoiseOf noise = calibrate::NoiseOf::frames;
    std::vector<std::string> units;  ///< of the numbers
    std::string about;               ///< "a flock": the uniform state of the waves
    std::vector<Entry> state;        ///< its values
};

/// The frames of a run with a model of its own, whose scene may be another one with the same fields.  Throws as
/// make_wave_fit.
WaveProblem model_wave_problem(const io::Scene& scene, const std::vector<std::string>& keys, const WaveChoice& choice,
                               const files::ArchiveReader& archive, const std::string& name, const io::Scene& source);

/// How steady the mean of a vector is over the frames of its amplitudes at q = 0, |mean|^2/<|F|^2>: whether it is the
/// order of a flock.  Throws an input Error for an order that is neither there nor gone.
bool is_steady(double mean_square, double square, const std::string& archive, const std::string& field);

/// Removes the mean of an archive from its waves.  Throws an input Error where no other wave is left.
void leave_out_mean(calibrate::WaveRecord& record, const std::string& archive, double max_wavenumber);

}  // namespace drover::run
