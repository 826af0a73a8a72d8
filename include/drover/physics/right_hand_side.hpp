// physics/right_hand_side.hpp: all of a model that its exact linear part leaves over, as the N of a System.
#pragma once
#include <memory>

#include "drover/base/threads.hpp"
#include "drover/numerics/transform.hpp"
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

    /// Writes the kept modes of `rate`; the others must be zero already.  Throws a run Error where the beads of a
    /// dynamic velocity leave a vacuum, which their inertia divides by, or a density leaves a coefficient's table.
    void operator()(double t, const numerics::Spectra& state, numerics::Spectra& rate);

    /// Of the last evaluation.
    Extremes extremes() const;

    /// Of a slaved form: the velocity of the beads on the grid, two components, in balance with the forces at each
    /// point.
    numerics::Fields bead_velocity(double t, const numerics::Spectra& state, const numerics::Transform& transform);

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// The velocity of the beads of a slaved form on the grid, two components, in balance with the forces at every point.
/// `linear`: the linear part about the scene's uniform densities.
numerics::Fields slaved_velocity(const Equations& equations, const numerics::System& linear, double t,
                                 const numerics::Spectra& state, const numerics::Transform& transform);

}  // namespace drover::physics
