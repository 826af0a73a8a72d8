// numerics/stepper.hpp: steps of a System: linear part and noise exact, the rest by the table of an exponential method.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

class NoisePath;  // src/numerics/steppers/noise_path.hpp

/// Arrays that hold nothing between steps: Runge-Kutta steppers of one method, grid and layout can share them.
struct StepperScratch {
    std::vector<Spectra> rates;  ///< in the order of StepperTable
    Spectra stage, next;
};

/// A method applied to one system with one step.  The blocks of each |q| are computed at construction.
class Stepper {
public:
    /// A stepper with a noise path of its own.  Copies the system and the table; `threads` must outlive it.  Throws an
    /// input Error for an invalid grid, table or dt and for scratch of another grid, layout or method, and a run Error
    /// if a linear mode grows beyond the range of numbers in one step.
    Stepper(const System& system, const StepperTable& table, double dt, std::uint64_t seed, Threads& threads,
            std::shared_ptr<StepperScratch> scratch = nullptr);
    /// For drover itself: steps of dt/2^halvings on a noise path made for dt.
    Stepper(const System& system, const StepperTable& table, double dt, int halvings, std::shared_ptr<NoisePath> noise,
            Threads& threads, std::shared_ptr<StepperScratch> scratch = nullptr);
    ~Stepper();
    Stepper(Stepper&&) noexcept;  ///< one that was moved from can only be assigned to or destroyed
    Stepper& operator=(Stepper&&) noexcept;

    /// From a(t) to a(t + dt) in place.  Modes that are not kept must be zero.  The noise is that of the interval
    /// `step_number` of length dt.  A multistep method starts anew where step_number does not follow that of the last
    /// call; otherwise `state` must be the result of that call.
    /// Throws an input Error for a state of another grid or layout.
    /// knows_first_rate: a Runge-Kutta stepper of the same method and scratch has just taken a step from this state.
    void step(double t, std::uint64_t step_number, Spectra& state, bool knows_first_rate = false);

    /// Of the last step of a multistep method: its error, the new state less a more accurate one.  False, and `error`
    /// as it was, for other methods, and while the method has too few earlier rates.
    bool last_error(double t_end, const Spectra& state, Spectra& error);
    /// The number of steps from the last one to the next with such an error; 0: none has.
    std::int64_t steps_to_error() const;

    /// Right-hand sides of the last step of a multistep method; 0 of other methods.
    std::int64_t right_hand_sides() const;

    /// The rates of earlier steps of a multistep method; empty for other methods and before the first step.
    std::vector<double> save_history() const;
    void restore_history(std::span<const double> saved);

    /// Whether the method has an embedded error estimate for steps of any length.
    bool estimates_error() const;

    /// A step that may still be rejected: next = a(t + dt), error = an estimate of its local error (with noise: on the
    /// same noise path).  Throws an input Error for a method without an estimate, and for arrays, all three, that are
    /// not of the grid and layout of the system.
    void attempt(double t, std::uint64_t step_number, const Spectra& state, Spectra& next, Spectra& error);

    double dt() const;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// Memory of `count` steppers of a method that share what they can, without their noise path [bytes].
double stepper_bytes(const System& system, const StepperTable& table, int count);

/// A sample of the stationary distribution of the linear system; modes at q = 0 that do not decay are zero.
/// `state` is of the grid and layout of the system.  Throws an input Error if it is not, and for a system without
/// noise, and a run Error where a mode with q != 0 grows or does not decay.
void draw_stationary(const System& system, const RandomKey& key, Spectra& state);

}  // namespace drover::numerics
