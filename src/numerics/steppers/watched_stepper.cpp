// numerics/steppers/watched_stepper.cpp: which steps are repeated to measure their error.
#include "numerics/steppers/watched_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/base/error.hpp"

namespace drover::numerics {

WatchedStepper::WatchedStepper(const StepControl& control, System system, std::uint64_t seed, Threads& threads,
                               const std::optional<ErrorEquations>& watched)
    : stepper_(control, std::move(system), seed, threads), observing_(control.work.observing) {
    if (!watched || !stepper_.system().nonlinear) return;
    error_.emplace(*watched, stepper_.system().grid, control);
    const auto count = static_cast<std::size_t>(components(stepper_.system().layout));
    sizes_.assign(2 * count, 0.0);
    changes_.assign(count, 0.0);
}

void WatchedStepper::set_system(System system, const ErrorEquations::OnGrid& on_grid) {
    stepper_.set_system(std::move(system));
    if (error_) error_->set_equations(on_grid);
}

namespace {
/// Steps until the next is repeated in halves, if that may be spent.  Local errors change most at the start.
std::int64_t steps_to_dear_check(std::int64_t step) { return std::clamp<std::int64_t>(2 * step / 3, 1, 500); }
/// Where the error of a step costs no right-hand side.
std::int64_t steps_to_cheap_check(std::int64_t step) { return std::clamp<std::int64_t>(step / 16, 1, 100); }

/// Mean squares of each component: of all its modes, and without its mean.
std::vector<double> mean_squares(const Spectra& state) {
    std::vector<double> squares;
    for (int c = 0; c < state.count(); ++c) {
        double waves = 0.0;
        for (std::size_t mode = 1; mode < state.size; ++mode) waves += std::norm(state[c][mode]);
        squares.push_back(waves + std::norm(state[c][0]));
        squares.push_back(waves);
    }
    return squares;
}

bool has_noise(const System& system) { return system.noise || system.product_noise; }

/// Mean squares of the change of each component in a step; 0 where noise changes it.
std::vector<double> changes_of(const System& system, const Spectra& before, const Spectra& after) {
    std::vector<double> squares(static_cast<std::size_t>(after.count()), 0.0);
    if (has_noise(system)) return squares;
    for (int c = 0; c < after.count(); ++c)
        for (std::size_t mode = 0; mode < after.size; ++mode)
            squares[static_cast<std::size_t>(c)] += std::norm(after[c][mode] - before[c][mode]);
    return squares;
}

/// A check for growth may take a 16th of what a regular one may, so that these can still be paid for.
constexpr double spared = 16.0;

constexpr double much = 1.5;  // growth of mean squares

bool has_grown(const std::vector<double>& before, const std::vector<double>& now) {
    const double min_size = 1e-10 * *std::ranges::max_element(now);
    for (std::size_t k = 0; k < now.size(); ++k)
        if (now[k] > much * before[k] && now[k] > min_size) return true;
    return false;
}

/// On average over the components: what an oscillation changes passes from one to another.
bool changes_faster(const std::vector<double>& before, const std::vector<double>& now,
                    const std::vector<double>& sizes) {
    const double rounding = 1e-16 * *std::ranges::max_element(sizes);
    double growth = 0.0, count = 0.0;
    for (std::size_t k = 0; k < now.size(); ++k) {
        if (std::max(now[k], before[k]) <= rounding) continue;
        growth += now[k] / before[k];  // infinite of the first change
        count += 1.0;
    }
    return growth > much * count;
}
}  // namespace

/// Between two checks the local errors follow the motion of the fields.  Where that is not what is found, checks follow
/// sooner, since the sum of errors that turn is much larger than it would seem.
std::int64_t WatchedStepper::steps_to_next_check(std::int64_t step, std::int64_t since_last) {
    const std::int64_t cheap = stepper_.steps_to_cheap_error();
    const std::int64_t longest = cheap > 0 ? std::max(cheap, steps_to_cheap_check(step)) : steps_to_dear_check(step);
    const std::int64_t afforded = error_->steps_to_afford(work_of_check(), std::max<std::int64_t>(64, step));
    const std::int64_t shortest = std::clamp<std::int64_t>(step / 16, 10, 20);
    known_until_ = INT64_MAX;
    if (!error_->follows_phases(std::max({longest, shortest, afforded}))) return std::max(longest, afforded);
    // Radians: with 0.5 the reported error of an oscillation was too small; beyond the largest it is not known.
    constexpr double turn = 0.1, largest_turn = 1.0, negligible = 1e-6;
    const double steps_a_radian =
        static_cast<double>(since_last) / error_->turn();  // infinite where nothing has turned
    std::int64_t wanted = longest;
    if (longest > shortest) {
        const double factor = std::clamp(turn / error_->turn(), 0.25, 2.0);
        wanted = std::clamp(static_cast<std::int64_t>(static_cast<double>(since_last) * factor), shortest, longest);
    }
    constexpr double forever = 1e9;
    if (steps_a_radian < forever && error_->largest_local().error * static_cast<double>(afforded) > negligible)
        known_until_ = step + std::max(wanted, static_cast<std::int64_t>(largest_turn * steps_a_radian));
    return std::max(wanted, afforded);
}

void WatchedStepper::advance(std::int64_t step, Spectra& state) {
    is_checked_ = error_ && step >= next_check_;
    if (is_checked_ || (error_ && !has_noise(stepper_.system()))) before_ = state;
    stepper_.advance(step, state);
    const double work = stepper_.work_of_step() + observing_;
    work_done_ += work;
    if (error_) error_->count_work(work_done_, work);
}

void WatchedStepper::watch(std::int64_t step, const Spectra& state) {
    if (!error_) return;
    if (is_checked_) measure_error(step, state);
    else if (watches_growth()) check_growth(step, state);
    if (step > known_until_) error_->wait();
    error_->advance(step + 1, state);
}

double WatchedStepper::work_of_check() { return stepper_.steps_to_cheap_error() > 0 ? 0.0 : stepper_.work_of_error(); }

/// Fields that have grown, or change faster, have larger local errors: the next step is checked.
void WatchedStepper::check_growth(std::int64_t step, const Spectra& state) {
    const std::vector<double> sizes = mean_squares(state);
    const bool grows =
        has_grown(sizes_, sizes) || changes_faster(changes_, changes_of(stepper_.system(), before_, state), sizes);
    if (!grows || error_->steps_to_afford(spared * work_of_check(), 2) > 1) return;
    next_check_ = step + 1;
    is_for_growth_ = true;
}

void WatchedStepper::measure_error(std::int64_t step, const Spectra& state) {
    error_->start_local(before_);
    sizes_ = mean_squares(state);
    const std::vector<double> changes = changes_of(stepper_.system(), before_, state);
    const bool grows = watches_growth() && (has_grown(mean_squares(before_), sizes_) ||
                                            (step == last_check_ + 1 && changes_faster(changes_, changes, sizes_)));
    // The largest so far, which is forgotten slowly: what an oscillation changes comes and goes.
    constexpr double remembered = 0.9;
    for (std::size_t k = 0; k < changes.size(); ++k) changes_[k] = std::max(changes[k], remembered * changes_[k]);
    const std::int64_t since_last = std::max<std::int64_t>(1, step - last_check_);
    const bool is_repeated = stepper_.find_error(step, state, before_);
    error_->add_local(before_, state, is_repeated ? stepper_.work_of_error() : 0.0, since_last);
    const std::int64_t next = steps_to_next_check(step, since_last);
    error_->continue_local(static_cast<double>(next) / static_cast<double>(since_last));
    next_check_ = step + next;
    const bool was_for_growth =
        std::exchange(is_for_growth_, grows && error_->steps_to_afford(spared * work_of_check(), 2) == 1);
    if (is_for_growth_) next_check_ = step + 1;
    last_check_ = step;
    const StepError::Relative local = error_->largest_local();
    // What grows without a limit ends the run by its cause, not by the step.
    if (was_for_growth) return;
    // Fields that overflow have no error; the check of the fields says which of them failed first.
    double square = 0.0;
    for (const Complex value : state.values) square += std::norm(value);
    if (std::isfinite(square) && !(local.error < 0.5))
        fail_run("the time step is too long: at t = {:.6g} one step of {:.4g} {}; choose time.dt <= {:.3g}{}",
                 (static_cast<double>(step) + 1.0) * stepper_.dt(), stepper_.dt(),
                 std::isfinite(local.error) ? text("is wrong by {:.3g} times the {}", local.error, local.field)
                                            : text("leaves the {} without a finite error", local.field),
                 stepper_.dt() / 4.0,
                 stepper_.system().product_noise ? ""  // of whose error a tolerance knows nothing
                 : stepper_.tolerance() > 0.0    ? ", or a smaller time.tolerance"
                                                 : ", or a time.tolerance");
}

void WatchedStepper::begin_anew() {
    stepper_.set_division(1);
    stepper_.restore_history({});
}

/// Of a checkpoint with the changes of the fields, which earlier versions did not watch.
constexpr double has_changes = 2.0;

std::vector<double> WatchedStepper::save() const {
    std::vector<double> values{static_cast<double>(stepper_.division()),
                               static_cast<double>(next_check_),
                               static_cast<double>(last_check_),
                               static_cast<double>(known_until_),
                               work_done_,
                               has_changes + (is_for_growth_ ? 1.0 : 0.0)};
    const std::vector<double> history = stepper_.save_history();
    values.insert(values.end(), history.begin(), history.end());
    if (!error_) return values;
    values.insert(values.end(), sizes_.begin(), sizes_.end());
    values.insert(values.end(), changes_.begin(), changes_.end());
    const std::vector<double> error = error_->save();
    values.insert(values.end(), error.begin(), error.end());
    return values;
}

void WatchedStepper::restore(std::span<const double> values) {
    constexpr std::size_t numbers = 6;
    const bool knows_changes = values.size() >= numbers && values[5] >= has_changes;
    const std::size_t changes = knows_changes ? changes_.size() : 0,
                      error_numbers = error_ ? sizes_.size() + changes + error_->saved_numbers() : 0;
    require(values.size() >= numbers + error_numbers, {},
            "the checkpoint contains {} stepper values; expected {} or more: it is damaged, or of another version of "
            "drover; restart with that version, or run the scene again",
            values.size(), numbers + error_numbers);
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
    known_until_ = values[3] < 0x1p53 ? static_cast<std::int64_t>(values[3]) : INT64_MAX;
    work_done_ = values[4];
    is_for_growth_ = std::fmod(values[5], has_changes) != 0.0;
    stepper_.restore_history(values.subspan(numbers, values.size() - numbers - error_numbers));
    if (!error_) return;
    const std::span<const double> of_error = values.last(error_numbers);
    std::copy_n(of_error.begin(), sizes_.size(), sizes_.begin());
    std::copy_n(of_error.begin() + static_cast<std::ptrdiff_t>(sizes_.size()), changes, changes_.begin());
    error_->restore(of_error.subspan(sizes_.size() + changes));
}

}  // namespace drover::numerics
