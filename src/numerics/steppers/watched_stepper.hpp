// numerics/steppers/watched_stepper.hpp: an adaptive stepper with an estimate of the error that its steps make in the
// fields.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "numerics/steppers/adaptive_stepper.hpp"
#include "numerics/steppers/step_error.hpp"

namespace drover::numerics {

/// Its internal state, besides the fields: the division of dt, the history of its method and the error so far.
class WatchedStepper {
public:
    /// watched: nothing where the error is not estimated; that of a system without N is 0.
    WatchedStepper(const StepControl& control, System system, std::uint64_t seed, Threads& threads,
                   const std::optional<ErrorEquations>& watched);

    /// The same equations with another linear part; the error evolves by `on_grid`.
    void set_system(System system, const ErrorEquations::OnGrid& on_grid);

    /// From step to step + 1 of dt.  Throws as AdaptiveStepper::advance.
    void advance(std::int64_t step, Spectra& state);
    /// Called after each advance() with what it made: the error so far.  Throws a run Error where a single step makes
    /// an error as large as half of a field.
    void watch(std::int64_t step, const Spectra& state);

    /// Begins anew from other fields: without a history, with dt whole.
    void begin_anew();

    const AdaptiveStepper& stepper() const { return stepper_; }

    /// The estimated error of the time steps so far; 0 where it is not estimated.
    StepError::Relative step_error() const { return error_ ? error_->largest() : StepError::Relative{}; }
    /// The error of the fields where it is known with its phases: see StepError::known().
    std::optional<Spectra> known_error() const { return error_ ? error_->known() : std::nullopt; }

    /// By the run so far, without what estimates of errors take: see StepWork.
    double work_done() const { return work_done_; }

    /// The values that a checkpoint stores besides the fields; restored for the present system.
    std::vector<double> save() const;
    void restore(std::span<const double> values);

private:
    void measure_error(std::int64_t step, const Spectra& state);
    double work_of_check();
    bool watches_growth() const { return error_ && !stepper_.system().noise; }
    void check_growth(std::int64_t step, const Spectra& state);
    std::int64_t steps_to_next_check(std::int64_t step, std::int64_t since_last);

    AdaptiveStepper stepper_;
    std::optional<StepError> error_;
    Spectra before_;               // the state before a step
    std::vector<double> sizes_;    // of the fields at the last check
    std::vector<double> changes_;  // the largest of the fields in a step, at any check so far
    std::int64_t last_check_ = 0, next_check_ = 0, known_until_ = INT64_MAX;
    double observing_;  // work of each dt
    double work_done_ = 0.0;
    bool is_checked_ = false;     // the last step
    bool is_for_growth_ = false;  // the next check
};

}  // namespace drover::numerics
