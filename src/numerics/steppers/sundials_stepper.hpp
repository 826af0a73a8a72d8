// numerics/steppers/sundials_stepper.hpp: systems without noise integrated by CVODE and ARKODE of SUNDIALS.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/system.hpp"
#include "numerics/steppers/time_method.hpp"

namespace drover::numerics {

/// Steps taken so far.
struct StepCount {
    std::int64_t accepted = 0, rejected = 0;
    std::int64_t right_hand_sides = 0;  ///< of multistep methods and of those of SUNDIALS
    double largest_error = 0.0;         ///< of an accepted part, relative; only with a tolerance, not of SUNDIALS
};

/// "SUNDIALS 6.4.1".
std::string sundials_library();

/// CVODE: backward differentiation or Adams formulas of variable order and step.  It may step beyond dt, unless the
/// system is timed, and interpolates its solution at multiples of dt; the equations of a step are solved by Newton's
/// method and GMRES, preconditioned by the blocks of L.  ARKODE: additive Runge-Kutta methods; L is implicit and solved
/// exactly by blocks, the rest explicit; steps of at most dt, or of dt without a tolerance.
///
/// The error of a step is the root of the sum of squares of those of the fields, each relative to the root mean square
/// of its field or, where larger, of the change of the field over dt at its present rate.
class SundialsStepper {
public:
    /// method: one of SUNDIALS.  tolerance 0: steps of dt.  Throws an input Error for a system with noise, and for a
    /// method that needs a tolerance without one.
    SundialsStepper(const System& system, const TimeMethod& method, double dt, double tolerance);
    ~SundialsStepper();
    SundialsStepper(SundialsStepper&&) noexcept;

    /// From step to step + 1 of dt.  Any other state than the result of the last call, and any other step, begins
    /// without history, as does the first dt after `steps_between_starts` of its own steps.  Throws the Error of the
    /// right-hand side, or a run Error where no step meets the tolerance.
    void advance(std::int64_t step, Spectra& state);
    static constexpr std::int64_t steps_between_starts = 1000;

    const StepCount& count() const;
    double last_step() const;  ///< [s]

    /// The history is not stored: these are the state and the step of the last start without one, and the step now.
    std::vector<double> save() const;
    /// Repeats the steps since that start: what follows is the same as without interruption.
    void restore(std::span<const double> values);
    std::size_t saved_numbers() const;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// Memory of a SundialsStepper [bytes].
double sundials_stepper_bytes(const System& system, const TimeMethod& method);

}  // namespace drover::numerics
