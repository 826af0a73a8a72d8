// physics/field_evolution.hpp: time integration of the fields, with a linear part that follows the bead density.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "drover/numerics/watched_stepper.hpp"
#include "drover/physics/right_hand_side.hpp"

namespace drover::physics {

/// The reference state of the exact linear part: the bead density of the uniform state times sqrt(2)^rung.  The
/// explicit remainder is stable if the reference is at most twice the smallest bead density for beads with inertia
/// (drag rate Gamma/(m rho)), or at least half the largest bead density for slaved beads (diffusion rho E/Gamma).
Reference reference_at(const UniformState& uniform, int rung);

/// The rung for given densities on the grid.  A hysteresis of half a rung prevents switching back and forth.
int follow_densities(const Equations& equations, const Extremes& extremes, int rung);

/// Its internal state, besides the fields: the rung of the reference, the division of dt and the error so far.
class FieldEvolution {
public:
    FieldEvolution(const Model& model, const numerics::Grid& grid, const Dealiasing& dealiasing,
                   const numerics::StepControl& control, std::uint64_t seed, Threads& threads);

    /// Chooses the reference for an initial state.
    void start(const numerics::Spectra& state);

    /// Advances the state from step to step + 1.  Throws a run Error that names the cause, also where a single step
    /// makes an error as large as half of a field.
    void advance(std::int64_t step, numerics::Spectra& state);

    const Equations& equations() const { return equations_; }
    /// The linear part about the uniform state of the model.
    const numerics::System& system() const { return linear_; }
    const numerics::AdaptiveStepper& stepper() const { return stepper_.stepper(); }
    std::int64_t reference_changes() const { return changes_; }

    /// The estimated error of the time steps so far; none of a linear model, which is exact.
    numerics::StepError::Relative step_error() const { return stepper_.step_error(); }
    /// The error of the fields where it is known with its phases: see StepError::known().
    std::optional<numerics::Spectra> known_error() const { return stepper_.known_error(); }

    /// Begins anew with the reference of another evolution of the same equations.
    void follow(const FieldEvolution& other);

    /// The values that a checkpoint stores besides the fields.
    std::vector<double> save() const;
    void restore(std::span<const double> values);

private:
    /// The equations about one reference.
    struct Split {
        numerics::System system;
        std::shared_ptr<RightHandSide> remainder;  // nullptr: every term is linear
    };
    static Split split_of(const Equations& equations, const numerics::Grid& grid, const Reference& about,
                          const Dealiasing& dealiasing, Threads& threads);
    Split split_at(int rung) const;
    numerics::ErrorEquations::OnGrid equations_on_grid(int rung) const;
    numerics::ErrorEquations watched() const;
    void set_reference(int rung);
    Extremes moving_extremes() const;
    void follow_beads(const Extremes& extremes);

    Equations equations_;
    numerics::Grid grid_;
    Dealiasing dealiasing_;
    Threads& threads_;
    numerics::System linear_;
    Split split_;
    numerics::WatchedStepper stepper_;
    int rung_ = 0;
    std::int64_t changes_ = 0;
};

}  // namespace drover::physics
