// run/halved_steps.hpp: a run from its start with a step that is halved while the step error asks for it.
#pragma once
#include <cmath>

#include "base/log.hpp"
#include "run/field_simulation.hpp"

namespace drover::run {

/// What `run` returns for the scene, or for the same with a shorter step.
template <class Run>
auto with_halved_steps(io::Scene scene, bool quiet, Run run) {
    for (int halvings = 0;;) {
        try {
            return run(scene);
        } catch (const StepTooLong& error) {
            // The error of a chaotic run exceeds any limit, however short the step.
            constexpr int max_halvings = 6;
            if (halvings >= max_halvings)
                fail_run(
                    "{}; {} halvings of the step did not suffice: the fields may be chaotic, or the grid too coarse: "
                    "give time.dt, and compare means with those of half of it, or more points",
                    error.what(), halvings);
            if (!quiet) log_information("{}; doing so now", error.what());
            halvings += error.halvings;
            scene.time.dt = std::ldexp(scene.time.dt, -error.halvings);
        }
    }
}

}  // namespace drover::run
