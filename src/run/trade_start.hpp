// run/trade_start.hpp: what the trials of a study start from.
#pragma once
#include "drover/io/scene.hpp"

namespace drover::run {

/// The scene with a step, few frames, and no limit on the estimate of its error.  Throws an input Error for a scene
/// without samples.
io::Scene trial_scene(const io::Scene& scene);

/// The scene on the finest grid on which one trial takes at most a fifth of the budget [core seconds].  Throws a run
/// Error where there is none.
io::Scene affordable_scene(const io::Scene& scene, double budget);

/// Durations of a scene are whole numbers of this [s].
double unit_of_time(const io::Scene& scene);

/// Of a run that takes a fortieth of the budget, and makes 64 samples at least [s].
double first_duration(const io::Scene& scene, double budget);

}  // namespace drover::run
