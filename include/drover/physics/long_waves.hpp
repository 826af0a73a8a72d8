// physics/long_waves.hpp: speeds and dampings of the slow modes of a uniform state, by angle, exact as q -> 0.
#pragma once
#include "drover/model/theory.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/uniform_states.hpp"

namespace drover::physics {

using model::LongWaves;
using model::slow_growth;
using model::slow_modes;
using model::SlowMode;

/// There is one slow mode for each conserved density, one for the free direction of a flock, and two for the momentum
/// of beads without drag.  The rows of `right` are the components of Equations::forces().
LongWaves long_waves(const Equations& equations, const StationaryState& about);

}  // namespace drover::physics
