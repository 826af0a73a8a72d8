// run/step_choice.hpp: the time step of a scene of fields that leaves time.dt out, and runs with ever shorter steps.
#pragma once
#include <cmath>

#include "base/log.hpp"
#include "run/fields/field_simulation.hpp"

namespace drover::run {

/// The scene with a time step whose error is below time.max_error (0.01 where that is 0), found by pilot runs in memory
/// with ever shorter steps; Scene::found tells how.  Without noise the error is that of the fields
/// (step_error), and time.tolerance then guards what the pilot has not seen.  With noise, or where the fields are
/// chaotic, it is the bias of the time means of the scalar observables, from two runs with dt and dt/2 on one noise
/// path.  Where time.stepper is left out too, the method is etdrk4-krogstad.  A large grid has a pilot with fewer
/// points.  A scene with a time step is returned as it is.  Unless quiet it logs that it has begun.  Throws a run Error
/// where no step is found, and on a stop signal.
io::Scene with_chosen_step(const io::Scene& scene, bool quiet);

/// What `run` returns for the scene or, while the step error asks for it, for the same with a halved step.
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
