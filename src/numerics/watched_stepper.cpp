// numerics/watched_stepper.cpp: which steps are repeated to measure their error.
#include "drover/numerics/watched_stepper.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"
#include "drover/numerics/time_method.hpp"

namespace drover::numerics {

WatchedStepper::WatchedStepper(const StepControl& control, System system, std::uint64_t seed, Threads& threads,
                               const std::optional<ErrorEquations>& watched)
    : stepper_(control, std::move(system), seed, threads) {
    if (watched && stepper_.system().nonlinear)
        error_.emplace(*watched, stepper_.system().grid, control.dt, std::max(2, time_method(control.method).stages),
                       control.tolerance > 0.0);
}

void WatchedStepper::set_system(System system, const ErrorEquations::OnGrid& on_grid) {
    stepper_.set_system(std::move(system));
    if (error_) error_->set_equations(on_grid);
}

namespace {
/// Steps until the next is repeated in halves, which costs two steps: 1.7 % of 2000 steps, 0.4 % of a long run.  Local
/// errors change most at the start.
std::int64_t steps_to_dear_check(std::int64_t step) { return std::clamp<std::int64_t>(2 * step / 3, 1, 500); }
/// Where the error of a step costs no right-hand side.
std::int64_t steps_to_cheap_check(std::int64_t step) { return std::clamp<std::int64_t>(step / 16, 1, 100); }
}  // namespace

/// Between two checks the local errors follow the motion of the fields.  Where that is not what is found, checks follow
/// sooner, since the sum of errors that turn is much larger than it would seem.
std::int64_t WatchedStepper::steps_to_next_check(std::int64_t step, std::int64_t since_last) {
    const std::int64_t cheap = stepper_.steps_to_cheap_error();
    const std::int64_t longest = cheap > 0 ? std::max(cheap, steps_to_cheap_check(step)) : steps_to_dear_check(step);
    const std::int64_t shortest = std::clamp<std::int64_t>(step / 16, 10, 20);
    constexpr double turn = 0.1;  // radians: with 0.5 the error of an oscillation was told too small
    if (longest <= shortest || !error_->follows_phases(longest)) return longest;
    const double factor = std::clamp(turn / error_->turn(), 0.25, 2.0);  // 2 where nothing has turned
    return std::clamp(static_cast<std::int64_t>(static_cast<double>(since_last) * factor), shortest, longest);
}

/// Whether the error of this step may be measured.
bool WatchedStepper::can_check(std::int64_t step) {
    const std::int64_t waited = step - last_check_;
    const bool is_late = waited > 3 * std::max(next_check_ - last_check_, std::clamp<std::int64_t>(step / 16, 7, 40));
    return error_->spend(stepper_.cost_of_error(), step, waited, is_late);
}

void WatchedStepper::advance(std::int64_t step, Spectra& state) {
    is_checked_ = error_ && step >= next_check_ && can_check(step);
    if (is_checked_) before_ = state;
    stepper_.advance(step, state);
}

void WatchedStepper::watch(std::int64_t step, const Spectra& state) {
    if (is_checked_) measure_error(step, state);
    if (error_) error_->advance(step + 1, state);
}

void WatchedStepper::measure_error(std::int64_t step, const Spectra& state) {
    error_->start_local(before_);
    stepper_.find_error(step, state, before_);
    error_->add_local(before_, state);
    const std::int64_t since_last = std::max<std::int64_t>(1, step - last_check_);
    const std::int64_t next = steps_to_next_check(step, since_last);
    error_->continue_local(static_cast<double>(next) / static_cast<double>(since_last));
    next_check_ = step + next;
    last_check_ = step;
    const StepError::Relative local = error_->largest_local();
    // Fields that overflow have no error; the check of the fields says which of them failed first.
    double square = 0.0;
    for (const Complex value : state.values) square += std::norm(value);
    if (std::isfinite(square) && !(local.error < 0.5))
        fail_run(
            "the time step is too long: at t = {:.6g} s one step of {:.4g} s {}; choose time.dt <= {:.3g}, or a "
            "time.tolerance",
            (static_cast<double>(step) + 1.0) * stepper_.dt(), stepper_.dt(),
            std::isfinite(local.error) ? text("is wrong by {:.3g} times the {}", local.error, local.field)
                                       : text("leaves the {} without a finite error", local.field),
            stepper_.dt() / 4.0);
}

void WatchedStepper::begin_anew() {
    stepper_.set_division(1);
    stepper_.restore_history({});
}

std::vector<double> WatchedStepper::save() const {
    std::vector<double> values{static_cast<double>(stepper_.division()), static_cast<double>(next_check_),
                               static_cast<double>(last_check_)};
    const std::vector<double> history = stepper_.save_history();
    values.insert(values.end(), history.begin(), history.end());
    if (!error_) return values;
    const std::vector<double> error = error_->save();
    values.insert(values.end(), error.begin(), error.end());
    return values;
}

void WatchedStepper::restore(std::span<const double> values) {
    const std::size_t error_numbers = error_ ? error_->saved_numbers() : 0;
    require(values.size() >= 3 + error_numbers, {}, "the checkpoint contains {} stepper values; expected {} or more",
            values.size(), 3 + error_numbers);
    const double division = values[0], next = values[1], last = values[2];
    require(division >= 1.0 && division <= AdaptiveStepper::max_division && division == std::round(division), {},
            "the checkpoint contains {} parts of a step; expected an integer from 1 to {}; use the other checkpoint",
            division, AdaptiveStepper::max_division);
    for (const double check : {next, last})
        require(std::isfinite(check) && check >= 0.0 && check < 0x1p53, {},
                "the checkpoint contains the step {}; expected 0 or more; use the other checkpoint", check);
    stepper_.set_division(static_cast<int>(division));
    next_check_ = static_cast<std::int64_t>(next);
    last_check_ = static_cast<std::int64_t>(last);
    stepper_.restore_history(values.subspan(3, values.size() - 3 - error_numbers));
    if (error_) error_->restore(values.last(error_numbers));
}

}  // namespace drover::numerics
