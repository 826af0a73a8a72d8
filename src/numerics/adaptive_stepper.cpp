// numerics/adaptive_stepper.cpp: control of the step by an embedded error estimate.
#include "drover/numerics/adaptive_stepper.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
/// The next smaller one of 1, 2, 3, 4, 6, 8, 12, 16, ...
int coarser(int division) {
    if (division <= 2) return 1;
    if (division == 3) return 2;
    const bool is_power = (division & (division - 1)) == 0;
    return is_power ? division / 4 * 3 : division / 3 * 2;
}
}  // namespace

AdaptiveStepper::AdaptiveStepper(const StepControl& control, System system, std::uint64_t seed, Threads& threads)
    : control_(control), seed_(seed), threads_(threads), system_(std::move(system)) {
    if (control_.tolerance == 0.0) return;
    next_ = Spectra(system_.grid, components(system_.layout));
    error_ = next_;
}

void AdaptiveStepper::set_system(System system) {
    steppers_.clear();
    system_ = std::move(system);
}

Stepper& AdaptiveStepper::stepper(int division) {
    if (const auto found = steppers_.find(division); found != steppers_.end()) return found->second;
    const auto made = steppers_.emplace(division, Stepper(system_, stepper_table(control_.method),
                                                          control_.dt / division, seed_, threads_));
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
    for (int first = 0, width = 1; first < after.count(); first += width) {
        width = first < system_.layout.scalars ? 1 : 2;
        double wrong = 0.0, size = 0.0, change = 0.0;
        for (int c = first; c < first + width; ++c)
            for (std::size_t m = 0; m < after.size; ++m) {
                wrong += std::norm(error[c][m]);
                size += std::norm(after[c][m]);
                change += std::norm(after[c][m] - before[c][m]);
            }
        if (!std::isfinite(wrong)) return INFINITY;
        const double scale = std::sqrt(std::max(size, parts * parts * change));
        if (wrong > 0.0) largest = std::max(largest, scale > 0.0 ? std::sqrt(wrong) / scale : INFINITY);
    }
    return largest;
}

void AdaptiveStepper::advance_in_parts(double t, Spectra& state) {
    const double tolerance = control_.tolerance;
    const int order = stepper_table(control_.method).order;  // the error of the pair is proportional to dt^order
    double largest = 0.0;
    for (int i = 0; i < division_;) {
        stepper(division_).attempt(t + control_.dt * i / division_, state, next_, error_);
        const double error = relative_error(state, next_, error_);
        if (error <= tolerance) {
            std::swap(state.values, next_.values);
            largest = std::max(largest, error);
            ++count_.accepted;
            ++i;
            continue;
        }
        ++count_.rejected;
        if (division_ > max_division / 2)
            fail_run(
                "no step down to {:.3g} s meets time.tolerance = {} at t = {:.6g} s: its estimated error is "
                "{:.3g}; the fields may be diverging; otherwise give a larger tolerance or a smaller time.dt",
                control_.dt / division_, tolerance, t, error);
        division_ *= 2;
        i *= 2;
    }
    constexpr double safety = 2.0;
    const double growth = static_cast<double>(division_) / coarser(division_);
    if (division_ > 1 && safety * largest * std::pow(growth, order) < tolerance) division_ = coarser(division_);
}

void AdaptiveStepper::advance(std::int64_t step, Spectra& state) {
    const double t = static_cast<double>(step) * control_.dt;
    if (control_.tolerance > 0.0 && system_.nonlinear) {
        advance_in_parts(t, state);
    } else {
        stepper(1).step(t, static_cast<std::uint64_t>(step), state);
        ++count_.accepted;
    }
}

}  // namespace drover::numerics
