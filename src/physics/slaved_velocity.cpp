// physics/slaved_velocity.cpp: the velocity of slaved beads, for outputs.
#include "drover/physics/right_hand_side.hpp"

namespace drover::physics {

using numerics::Spectra;

numerics::Fields slaved_velocity(const Equations& equations, const numerics::System& linear, double t,
                                 const Spectra& state, const numerics::Transform& transform) {
    Threads one(1);
    return RightHandSide(equations, linear, reference(equations.model.uniform), one).bead_velocity(t, state, transform);
}

}  // namespace drover::physics
