// numerics/steppers/adaptive_stepper.cpp: control of the step by an embedded error estimate.
#include "numerics/steppers/adaptive_stepper.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "drover/base/error.hpp"
#include "numerics/steppers/noise_path.hpp"
#include "numerics/steppers/time_method.hpp"

namespace drover::numerics {

/// The next smaller number of parts.
int AdaptiveStepper::coarser() const {
    const bool is_power = (division_ & (division_ - 1)) == 0;
    if (division_ <= 3) return division_ == 3 ? 2 : 1;
    if (noise_) return division_ / 2;
    return is_power ? division_ / 4 * 3 : division_ / 3 * 2;
}

AdaptiveStepper::AdaptiveStepper(const StepControl& control, System system, std::uint64_t seed, Threads& threads)
    : control_(control),
      seed_(seed),
      threads_(threads),
      system_(std::move(system)),
      noise_(make_noise_path(system_, control.dt, seed, threads)) {
    make_sundials();
    if (control_.tolerance == 0.0) return;
    next_ = Spectra(system_.grid, components(system_.layout));
    error_ = next_;
}

void AdaptiveStepper::set_system(System system) {
    steppers_.clear();
    system_ = std::move(system);
    noise_ = make_noise_path(system_, control_.dt, seed_, threads_);
    make_sundials();
}

void AdaptiveStepper::make_sundials() {
    finer_sundials_.reset();
    if (const TimeMethod& method = time_method(control_.method); !method.is_exponential)
        sundials_.emplace(system_, method, control_.dt, control_.tolerance);
}

Stepper& AdaptiveStepper::stepper(int division) {
    if (const auto found = steppers_.find(division); found != steppers_.end()) return found->second;
    const StepperTable& table = stepper_table(control_.method);
    const auto made =
        steppers_.emplace(division,
                          noise_
                              ? Stepper(system_, table, control_.dt,
                                        std::bit_width(static_cast<unsigned>(division)) - 1, noise_, threads_, scratch_)
                              : Stepper(system_, table, control_.dt / division, seed_, threads_, scratch_));
    // Divisions in use are neighbours; others only hold memory.
    constexpr std::size_t kept = 4;
    while (steppers_.size() > kept) {
        const bool first_is_farther = division - steppers_.begin()->first > steppers_.rbegin()->first - division;
        steppers_.erase(first_is_farther ? steppers_.begin() : std::prev(steppers_.end()));
    }
    return made.first->second;
}

/// The largest relative error of any field, as root mean squares over its modes.  Its size is that of the field or,
/// where larger, that of its change over dt at the present rate: a field that starts from zero has no size of its own.
double AdaptiveStepper::relative_error(const Spectra& before, const Spectra& after, const Spectra& error) const {
    const double parts = division_;
    double largest = 0.0;
    int first = 0;
    for (const FieldKind& kind : system_.layout.fields) {
        double wrong = 0.0, size = 0.0, change = 0.0;
        for (int c = first; c < first + components(kind); ++c)
            for (std::size_t m = 0; m < after.size; ++m) {
                wrong += std::norm(error[c][m]);
                size += std::norm(after[c][m]);
                change += std::norm(after[c][m] - before[c][m]);
            }
        first += components(kind);
        if (!std::isfinite(wrong)) return INFINITY;
        const double scale = std::sqrt(std::max(size, parts * parts * change));
        if (wrong > 0.0) largest = std::max(largest, scale > 0.0 ? std::sqrt(wrong) / scale : INFINITY);
    }
    return largest;
}

bool AdaptiveStepper::takes_halves() const {
    return control_.tolerance > 0.0 && system_.nonlinear && system_.is_timed && !noise_ && !sundials_;
}

/// The halves into next_, and the error of the whole into error_.
void AdaptiveStepper::attempt_in_halves(double t, std::uint64_t part, const Spectra& state) {
    const double half = 0.5 * control_.dt / division_;
    error_.values = state.values;
    next_.values = state.values;
    stepper(division_).step(t, part, error_);
    Stepper& finer = stepper(2 * division_);
    finer.step(t, 2 * part, next_);
    finer.step(t + half, 2 * part + 1, next_);
    for (std::size_t k = 0; k < error_.values.size(); ++k) error_.values[k] -= next_.values[k];
}

/// The relative error of a part from t, whose result is in next_.  INFINITY where the right-hand side failed: outside
/// its domain a shorter part may stay within it.
double AdaptiveStepper::attempt(double t, std::uint64_t part, const Spectra& state) {
    failure_.clear();
    try {
        if (takes_halves()) attempt_in_halves(t, part, state);
        else stepper(division_).attempt(t, part, state, next_, error_);
    } catch (const Error& error) {
        if (error.fault() != Fault::run) throw;
        failure_ = error.what();
        return INFINITY;
    }
    return relative_error(state, next_, error_);
}

void AdaptiveStepper::advance_in_parts(std::int64_t step, Spectra& state) {
    const double t = static_cast<double>(step) * control_.dt, tolerance = control_.tolerance;
    const int order = stepper_table(control_.method).order;  // the error of an embedded pair is as dt^order, or smaller
    constexpr double safety = 2.0, largest_jump = 1e-3;
    double largest = 0.0;
    bool has_passed = true;  // the part before
    if (takes_halves()) of_parts_.assign(state.values.size(), 0.0);
    for (int i = 0; i < division_;) {
        const auto part =
            static_cast<std::uint64_t>(step) * static_cast<std::uint64_t>(division_) + static_cast<std::uint64_t>(i);
        const double now = t + control_.dt * i / division_, error = attempt(now, part, state);
        // The shortest part over a jump in t: its error is told by find_error().
        const bool jumps =
            takes_halves() && division_ > max_division / 2 && has_passed && error > tolerance && error < largest_jump;
        if (error <= tolerance || jumps) {
            has_passed = !jumps;
            std::swap(state.values, next_.values);
            largest = std::max(largest, error);
            count_.largest_error = std::max(count_.largest_error, error);
            count_.accepted += takes_halves() ? 2 : 1;
            ++i;
            if (!takes_halves()) continue;
            for (std::size_t k = 0; k < error_.values.size(); ++k) of_parts_[k] += error_.values[k];
            if (i % 2 == 0 && division_ % 2 == 0 && safety * std::ldexp(error, order) < tolerance) {
                i /= 2;
                division_ /= 2;
                largest = std::ldexp(error, order);  // the parts before were shorter
            }
            continue;
        }
        ++count_.rejected;
        if (division_ > max_division / 2 && !failure_.empty())
            fail_run("{}; no step down to {:.3g} avoids this at t = {:.6g}", failure_, control_.dt / division_, now);
        if (division_ > max_division / 2)
            fail_run(
                "no step down to {:.3g} meets time.tolerance = {} at t = {:.6g}: its estimated error is "
                "{:.3g}; the fields may be diverging; otherwise give a larger tolerance or a smaller time.dt",
                control_.dt / division_, tolerance, now, error);
        division_ *= 2;
        i *= 2;
    }
    taken_ = division_;
    const double growth = static_cast<double>(division_) / coarser();
    if (division_ > 1 && safety * largest * std::pow(growth, order) < tolerance) division_ = coarser();
}

void AdaptiveStepper::advance(std::int64_t step, Spectra& state) {
    count_before_ = count_;
    if (sundials_) {
        advance_by_sundials(step, state);
    } else if (control_.tolerance > 0.0 && system_.nonlinear) {
        advance_in_parts(step, state);
    } else {
        Stepper& whole = stepper(1);
        whole.step(static_cast<double>(step) * control_.dt, static_cast<std::uint64_t>(step), state);
        ++count_.accepted;
        count_.right_hand_sides += whole.right_hand_sides();
    }
}

void AdaptiveStepper::advance_by_sundials(std::int64_t step, Spectra& state) {
    const StepCount before = sundials_->count();
    sundials_->advance(step, state);
    const StepCount& now = sundials_->count();
    count_.accepted += now.accepted - before.accepted;
    count_.rejected += now.rejected - before.rejected;
    count_.right_hand_sides += now.right_hand_sides - before.right_hand_sides;
}

namespace {
constexpr double finer_tolerance = 0.01;
}

void AdaptiveStepper::repeat_finer(std::int64_t step, Spectra& state) {
    if (sundials_) {
        const bool has_fixed_step = control_.tolerance == 0.0;
        const int parts = has_fixed_step ? 2 : 1;
        if (!finer_sundials_)
            finer_sundials_.emplace(system_, time_method(control_.method), control_.dt / parts,
                                    has_fixed_step ? 0.0 : std::max(1e-15, finer_tolerance * control_.tolerance));
        for (int i = 0; i < parts; ++i) finer_sundials_->advance(step * parts + i, state);
        return;
    }
    const int parts = 2 * taken_;
    Stepper& finer = stepper(parts);
    for (int i = 0; i < parts; ++i)
        finer.step(control_.dt * (static_cast<double>(step) + static_cast<double>(i) / parts),
                   static_cast<std::uint64_t>(step) * static_cast<std::uint64_t>(parts) + static_cast<std::uint64_t>(i),
                   state, shares_first_rate() && i == 0);
}

/// Whether a step begins with the same rate as when it is repeated: unless that depends on the step.
bool AdaptiveStepper::shares_first_rate() const {
    return !sundials_ && control_.tolerance == 0.0 && !system_.set_step && stepper_table(control_.method).history == 0;
}

/// The error of repeat_finer(), relative to that of advance().
double AdaptiveStepper::finer_error() const {
    if (sundials_ && control_.tolerance > 0.0) return finer_tolerance;
    // Of a method of order n, half a step makes an error 2^(n+1) times smaller, twice; with noise the strong order of
    // all but Euler's is near 1.5.
    const TimeMethod& method = time_method(control_.method);
    const int order = method.start.empty() ? method.order : time_method(method.start).order;
    return std::exp2(noise_ ? -1.5 : -static_cast<double>(order));
}

bool AdaptiveStepper::find_error(std::int64_t step, const Spectra& after, Spectra& before) {
    if (takes_halves()) {
        // At least a third of the difference: jumps and stiff terms reduce the order.
        constexpr double least = 0.25;
        const double finer = std::max(finer_error(), least), of_halves = finer / (1.0 - finer);
        for (std::size_t k = 0; k < before.values.size(); ++k) before.values[k] = of_halves * of_parts_[k];
        return false;
    }
    if (!sundials_ && stepper(1).last_error(static_cast<double>(step + 1) * control_.dt, after, before)) return false;
    repeat_finer(step, before);
    const double factor = 1.0 / (1.0 - finer_error());
    for (std::size_t k = 0; k < before.values.size(); ++k)
        before.values[k] = factor * (after.values[k] - before.values[k]);
    return true;
}

std::int64_t AdaptiveStepper::steps_to_cheap_error() {
    return takes_halves() ? 1 : sundials_ ? 0 : stepper(1).steps_to_error();
}

double AdaptiveStepper::work_of_step() const {
    // Of differences of integers, which are the same after a restart.
    const TimeMethod& method = time_method(control_.method);
    const std::int64_t accepted = count_.accepted - count_before_.accepted,
                       rejected = count_.rejected - count_before_.rejected;
    const std::int64_t steps = (takes_halves() ? accepted / 2 : accepted) + rejected;
    const int stages = stages_per_part(method, control_.tolerance > 0.0, takes_halves());
    const std::int64_t counted = count_.right_hand_sides - count_before_.right_hand_sides,
                       rates = counted > 0 ? counted : steps * stages;
    return static_cast<double>(rates) * control_.work.rate + static_cast<double>(steps) * control_.work.noise;
}

double AdaptiveStepper::work_of_error() const {
    constexpr double in_halves = 2.0, by_sundials = 3.0;  // the latter with a smaller tolerance
    const double work = (sundials_ ? by_sundials : in_halves) * work_of_step();
    return std::max(0.0, shares_first_rate() ? work - control_.work.rate : work);
}

double AdaptiveStepper::last_step() const {
    if (sundials_) return sundials_->last_step();
    return control_.dt / (takes_halves() ? 2 * division_ : division_);
}

std::vector<double> AdaptiveStepper::save_history() const {
    if (sundials_) return sundials_->save();
    const auto found = steppers_.find(1);
    return found == steppers_.end() ? std::vector<double>{} : found->second.save_history();
}

void AdaptiveStepper::restore_history(std::span<const double> saved) {
    if (sundials_) sundials_->restore(saved);
    else stepper(1).restore_history(saved);
}

}  // namespace drover::numerics
