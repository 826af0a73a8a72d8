// run/step_choice.hpp: the time step of a scene of fields that leaves time.dt out.
#pragma once
#include "io/scene.hpp"

namespace drover::run {

/// The scene with a time step whose error is below time.max_error (0.01 where that is 0), found by pilot runs in memory
/// with ever shorter steps; time.chosen and time.pilot tell how.  Without noise the error is that of the fields
/// (step_error), and time.tolerance then guards what the pilot has not seen.  With noise, or where the fields are
/// chaotic, it is the bias of the time means of the scalar observables, from two runs with dt and dt/2 on one noise
/// path.  Where time.stepper is left out too, the method is etdrk4-krogstad.  A large grid has a pilot with fewer
/// points.  A scene with a time step is returned as it is.  Unless quiet it logs that it has begun.  Throws a run Error
/// where no step is found, and on a stop signal.
io::Scene with_chosen_step(const io::Scene& scene, bool quiet);

}  // namespace drover::run
