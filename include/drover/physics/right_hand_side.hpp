// physics/right_hand_side.hpp: the explicit right-hand side N of a System: the model minus its exact linear part.
#pragma once
#include <memory>

#include "drover/base/threads.hpp"
#include "drover/physics/density_extremes.hpp"
#include "drover/physics/evaluation_cost.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

/// N(t, a): the right-hand side of the equations less its linear part about a reference.
class RightHandSide {
public:
    /// `linear`: the linear part about the same reference, on its grid.
    RightHandSide(const Equations& equations, const numerics::System& linear, const Reference& reference,
                  Threads& threads);
    ~RightHandSide();

    /// Writes the kept modes of `rate`; the others must already be zero.  Throws a run Error if a dynamic velocity
    /// meets a vanishing bead density (the equations divide by m rho), or if a density leaves a coefficient table.
    void operator()(double t, const numerics::Spectra& state, numerics::Spectra& rate);

    /// For steps of dt, a lower bound of the mass that moves: see model::ExplicitPart.
    void set_step(double dt);

    /// Extremes of the last evaluation.
    Extremes extremes() const;
    /// The smallest density that it has divided by.
    double min_moving_density() const;

    /// Slaved forms only: the bead velocity on the grid, two components, from the force balance at each point.
    numerics::Fields bead_velocity(double t, const numerics::Spectra& state) const;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// The velocity of the beads of a slaved form on the grid, two components, in balance with the forces at every point.
/// `linear`: the linear part about the scene's uniform densities.
numerics::Fields slaved_velocity(const Equations& equations, const numerics::System& linear, double t,
                                 const numerics::Spectra& state);

}  // namespace drover::physics
