// run/wave_problem.cpp: the mean of frames, as a state or as a wave.
#include "run/wave_problem.hpp"

#include <cmath>

namespace drover::run {

bool is_steady(double mean_square, double square, const std::string& archive, const std::string& field) {
    const double steadiness = square > 0.0 ? mean_square / square : 0.0;
    require(
        steadiness <= 0.5 || steadiness > 0.9, {archive},
        "has a {} over these frames of {:.2g} of its root mean square; expected less than 0.7 (no order) or more than "
        "0.95 (a flock that keeps its direction): choose more frames, or fewer with --from and --to",
        field, std::sqrt(steadiness));
    return steadiness > 0.5;
}

void leave_out_mean(calibrate::WaveRecord& record, const std::string& archive, double max_wavenumber) {
    require(record.q.size() > 1, {archive},
            "is of a flock, whose mean is no wave, and has no other up to {:.4g} /mm; expected some: choose a "
            "larger --max-wavenumber",
            max_wavenumber);
    record.q.erase(record.q.begin());
    record.amplitudes.erase(record.amplitudes.begin());
}

}  // namespace drover::run
