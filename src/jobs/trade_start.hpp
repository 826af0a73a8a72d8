// jobs/trade_start.hpp: what the trials of a study start from.
#pragma once
#include <optional>

#include "jobs/trade_bench.hpp"

namespace drover::jobs {

/// The scene with a step, few frames, and no limit on the estimate of its error.  Throws an input Error for a scene
/// without samples.
io::Scene trial_scene(const io::Scene& scene);

/// What the trials of a study have in common.
struct TrialStart {
    io::Scene scene;        ///< without noise on the finest grid on which a trial takes at most a fifth of the budget
    double duration = 0.0;  ///< of a noisy scene as its budget allows; else that of the run [s]
};
/// Both follow from timings, so all processes in the folder take what the first has found.  Nothing when a signal came.
/// Throws a run Error where no grid is coarse enough.
std::optional<TrialStart> trial_start(TradeBench& bench);

/// Durations of a scene are whole numbers of this [s].
double unit_of_time(const io::Scene& scene);

}  // namespace drover::jobs
