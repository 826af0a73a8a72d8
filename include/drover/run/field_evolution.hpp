// run/field_evolution.hpp: fields carried from one step of the loop to the next, by as many steps of the stepper as that takes.
#pragma once
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "drover/io/scene.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/physics/right_hand_side.hpp"

namespace drover::run {

/// Steps taken so far in this process.
struct StepCount {
    std::int64_t accepted = 0, refused = 0, references = 0;
    int division = 1;  ///< steps that dt is cut into now
};

/// The reference densities and the division of dt follow the run; both are part of its state.
///
/// Reference: what varies with the density is split about the one of a ladder of factors sqrt(2) at which the explicit remainder
/// cannot amplify: at most twice the least bead density where beads have inertia (drag Gamma/(m rho)), at least half of the largest
/// where their velocity is slaved (diffusion rho E/Gamma).
/// Division: dt is cut into 1, 2, 3, 4, 6, 8, 12, ... equal steps (factors near sqrt(2) that end together with dt), doubled when the
/// embedded estimate refuses a step, one rung coarser when a whole dt went with room to spare.
class FieldEvolution {
public:
    FieldEvolution(const io::Scene& scene, Threads& threads);
    ~FieldEvolution();

    /// Chooses the reference for a state that no step has led to.
    void start(const numerics::Spectra& state);

    /// From step to step + 1 of the scene's dt.  Throws a run Error that says why it cannot.
    void advance(std::int64_t step, numerics::Spectra& state);

    const physics::Equations& equations() const { return equations_; }
    const numerics::System& system() const { return linear_; }  ///< the linear part about the scene's uniform state
    const StepCount& count() const { return count_; }

    /// What a checkpoint must know besides the fields.
    std::vector<double> save() const;
    void restore(std::span<const double> values);
    static constexpr std::size_t saved_numbers = 2;

private:
    struct Solver;
    Solver& solver(int division);
    void advance_adaptively(double t, numerics::Spectra& state);
    void follow_densities(const physics::Extremes& extremes);
    double relative_error(const numerics::Spectra& error, const numerics::Spectra& before,
                          const numerics::Spectra& after) const;

    io::Scene scene_;
    physics::Equations equations_;
    numerics::System linear_;
    Threads& threads_;
    int reference_rung_ = 0;  // the bead density of the reference is that of the scene times sqrt(2)^rung
    std::map<int, std::unique_ptr<Solver>> solvers_;  // by division, for the present reference
    numerics::Spectra next_, error_;
    StepCount count_;
};

}  // namespace drover::run
