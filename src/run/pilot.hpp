// run/pilot.hpp: a run of fields in memory, for the scalar observables and the error of its steps.
#pragma once
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"

namespace drover::run {

struct Pilot {
    std::vector<std::string> names;           ///< of the scalar observables, step_error left out
    std::vector<std::vector<double>> series;  ///< by name
    double step_error = 0.0;                  ///< the largest so far
    double stopped = INFINITY;                ///< time at which the error exceeded the limit, or the run failed [s]
    std::optional<std::string> failure;       ///< why the run failed, if it did
    numerics::StepCount count;
};

/// Runs a scene to its end, or to where its step_error exceeds max_step_error.  Throws a run Error on a stop signal.
Pilot run_pilot(const io::Scene& scene, Threads& threads, double max_step_error);

}  // namespace drover::run
