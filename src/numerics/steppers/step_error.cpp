// numerics/steppers/step_error.cpp: what is told of the error of the time steps, and its state.
#include "numerics/steppers/step_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/fields/shells.hpp"
#include "numerics/steppers/error_evolution.hpp"

namespace drover::numerics {

namespace {
/// Fields are measured so often in the run so far, and at each check.
constexpr std::int64_t min_moments = 64;

/// Of fields that are 0 at the start; of the local error, which ends a run, more.
constexpr std::int64_t first_steps = 4, first_local_steps = 16;

/// Random errors of noisy steps are measured too large: on 60 random scenes with noise the estimate without this factor
/// was 1.5 times the error in the median (tests/bench/step_error).
constexpr double random_errors = 0.7;
}  // namespace

StepError::StepError(const ErrorEquations& equations, const Grid& grid, const StepControl& control)
    : work_(std::make_unique<ErrorEvolution>(equations, grid, control)) {}
StepError::~StepError() = default;
StepError::StepError(StepError&&) noexcept = default;

void StepError::set_equations(const ErrorEquations::OnGrid& on_grid) {
    work_->equations.on_grid = on_grid;
    work_->set_equations();
}

void StepError::add_local(const Spectra& local, const Spectra& fields, double work, std::int64_t waited) {
    ErrorEvolution& w = *work_;
    for (Effort* effort : {&w.effort, &w.checks}) effort->spent += work + w.work_of_local;
    std::fill(w.shifted.values.begin(), w.shifted.values.end(), Complex(0.0));
    for (int c = 0; c < w.shifted.count(); ++c)
        for (const ModePair& pair : w.shared) w.shifted[c][pair.coarse] = local[c][pair.fine];
    for (std::size_t k = 0; k < w.wave_local.size(); ++k) w.wave_local[k] = std::abs(w.shifted.values[k]);
    w.add_unresolved_waves(fields);
    w.measure_fluctuations(fields, 0.0);
    double before = 0.0, now = 0.0;  // in the same units: what an oscillation has passes from field to field
    for (FieldSize& field : w.fields) {
        before += std::pow(ratio(field.local, field.fluctuation()), 2.0);
        field.local = field.size_of(local, w.fine);
        field.local_low = w.size_of(w.shifted, field);
        now += std::pow(ratio(field.local, field.fluctuation()), 2.0);
    }
    for (int c = 0; c < w.start.count(); ++c)
        for (const ModePair& pair : w.shared) w.start[c][pair.coarse] = fields[c][pair.fine] - w.start[c][pair.coarse];
    w.unforeseen = w.angle_to_drive();
    // After a long wait: whether the errors that were added were others than those that were made, and matter.
    constexpr double unlike = 0.5, matters = 0.1;  // radians; of the error
    const bool is_unlike = w.is_waiting && w.unforeseen > unlike;
    w.is_lost =
        w.is_lost || (is_unlike && static_cast<double>(waited) * w.local_size() > matters * w.relative_size(w.error));
    w.is_waiting = false;
    w.local.add(w.shifted, w.start, std::sqrt(now), std::sqrt(before), w.fields, w.coarse);
    w.bound();
}

void StepError::continue_local(double intervals) {
    ErrorEvolution& w = *work_;
    if (w.noisy) {
        w.drive.values = w.local.last.values;
        return;
    }
    if (w.follows) w.drive.values = w.local.last.values;
    else w.local.predict(intervals, w.drive);
    for (Complex& value : w.drive.values) value /= w.dt;
}

void StepError::start_local(const Spectra& before) {
    ErrorEvolution& w = *work_;
    if (w.fields.front().moments == 0.0) {
        w.measure_fluctuations(before, 1.0);
        for (FieldSize& field : w.fields) field.start = field.size;
        w.sample(before, w.from);
    }
    for (int c = 0; c < w.start.count(); ++c)
        for (const ModePair& pair : w.shared) w.start[c][pair.coarse] = before[c][pair.fine];
    if (w.waves.empty()) return;
    w.sample(before, w.between);
    if (w.rate_before.size == 0) w.rate_before = w.between.fields;
    try {
        w.remainder(0.0, w.between.fields, w.rate_before);
    } catch (const Error&) {  // a density that only the fine grid resolves
        w.rate_before = Spectra();
    }
}

void StepError::advance(std::int64_t step, const Spectra& fields) {
    ErrorEvolution& w = *work_;
    w.steps = step;
    for (int c = 0; c < w.error.count(); ++c)
        for (const FastWave& wave : w.waves) {
            const std::size_t k = static_cast<std::size_t>(c) * w.error.size + wave.mode;
            w.wave_error[k] = wave.kept * w.wave_error[k] + w.wave_local[k];
        }
    ++w.since;
    if (w.is_lost) return;
    if (w.leap > 0) {
        if (w.since >= w.leap) w.end_leap(fields);
        return;
    }
    for (std::size_t k = 0; k < w.driven.values.size(); ++k) w.driven.values[k] += w.drive.values[k];
    if (w.since < w.stride) return;
    const bool has_start = w.fields.front().moments > 0.0;
    if (min_moments * (step - w.last_moment) >= step) {
        w.measure_fluctuations(fields, static_cast<double>(step - w.last_moment));
        w.last_moment = step;
    }
    w.sample(fields, w.to);
    if (!has_start) w.from.fields = w.to.fields;
    for (Complex& value : w.driven.values) value /= static_cast<double>(w.since);
    w.follow_motion();
    w.earlier.values = w.error.values;
    w.add_random_errors(step, 0);
    w.evolve(step);
    w.add_random_errors(step, 1);
    w.leave_out_direction();
    w.bound();
    std::swap(w.from, w.to);
    std::fill(w.driven.values.begin(), w.driven.values.end(), Complex(0.0));
    w.since = 0;
    w.choose_leap(step);
    w.choose_stride(step);
}

void StepError::count_work(double done, double of_step) {
    work_->effort.done = work_->checks.done = done;
    work_->work_of_run_step = of_step;
}

std::int64_t StepError::steps_to_afford(double work, std::int64_t most) const {
    const ErrorEvolution& w = *work_;
    constexpr double part = 0.25;  // of what is left: the first steps may not take all
    const Effort& checks = w.checks;
    if (std::isinf(checks.part)) return 1;
    const double left = checks.allowed() + owed_work() - checks.spent,
                 steps = (work + w.work_of_local - part * left) / checks.gain(w.work_of_run_step);
    return static_cast<std::int64_t>(std::clamp(steps, 1.0, static_cast<double>(most)));
}

void StepError::wait() { work_->is_waiting = true; }

StepError::Relative StepError::largest() const {
    const ErrorEvolution& w = *work_;
    if (w.is_lost || w.is_waiting) return {.error = NAN, .field = w.fields.front().name};
    const Spectra error = w.error_now();
    Relative result{.error = 0.0, .field = w.fields.front().name};
    for (const FieldSize& field : w.fields) {
        // Of the last step nothing has decayed yet.
        const double size = std::max(field.local, std::hypot(w.size_of(error, field), w.size_without_phase(field)));
        const double relative = (w.noisy ? random_errors : 1.0) * ratio(size, field.fluctuation());
        if (relative > result.error && w.has_size(field, first_steps)) result = {std::min(relative, 1.0), field.name};
    }
    return result;
}

std::optional<Spectra> StepError::known() const {
    const ErrorEvolution& w = *work_;
    constexpr double definite = 0.5;  // of the fluctuation
    if (w.noisy || !(largest().error <= definite)) return std::nullopt;
    const Spectra now = w.error_now();
    Spectra result(w.fine.grid, now.count());
    for (const FieldSize& field : w.fields)
        if (w.size_without_phase(field) > w.size_of(now, field)) return std::nullopt;
    for (int c = 0; c < now.count(); ++c)
        for (const ModePair& pair : w.shared) result[c][pair.fine] = now[c][pair.coarse];
    return result;
}

double StepError::turn() const { return work_->unforeseen; }

bool StepError::follows_phases(std::int64_t steps) const {
    const ErrorEvolution& w = *work_;
    constexpr double parted = 0.5, negligible = 0.1;
    if (w.noisy || !(largest().error <= parted)) return false;
    return static_cast<double>(steps) * w.local_size() > negligible * w.relative_size(w.error);
}

StepError::Relative StepError::largest_local() const {
    Relative result{.error = 0.0, .field = work_->fields.front().name};
    for (const FieldSize& field : work_->fields)
        if (const double error = ratio(field.local, field.scale());
            !(error <= result.error) && work_->has_size(field, first_local_steps))
            result = {error, field.name};
    return result;
}

namespace {
/// The saved numbers of a field.
template <class Field>
auto saved_of(Field& field) {
    return std::array{&field.size,    &field.largest, &field.start,    &field.local,    &field.local_low,
                      &field.moments, &field.squares, &field.means[0], &field.means[1], &field.variance};
}
constexpr std::size_t saved_of_field = 10;
template <class Evolution>
auto saved_spectra(Evolution& work) {
    return std::array{&work.error,       &work.local.last,   &work.local.before,
                      &work.local.other, &work.local.motion, &work.local.other_motion,
                      &work.drive,       &work.driven,       &work.from.fields,
                      &work.change,      &work.motion_before};
}
constexpr std::size_t saved_spectra_count = 11;
}  // namespace

std::size_t StepError::saved_numbers() const {
    return 15 + saved_of_field * work_->fields.size() + (2 + 2 * saved_spectra_count) * work_->error.values.size();
}

std::vector<double> StepError::save() const {
    std::vector<double> values{static_cast<double>(work_->stride),
                               static_cast<double>(work_->since),
                               static_cast<double>(work_->last_moment),
                               static_cast<double>(work_->steps),
                               static_cast<double>(work_->taken),
                               static_cast<double>(work_->leap),
                               work_->perturbation_growth,
                               work_->alignment,
                               work_->turn_rate,
                               work_->unforeseen,
                               work_->follows ? 1.0 : 0.0,
                               work_->effort.spent,
                               work_->checks.spent,
                               work_->is_lost ? 1.0 : 0.0,
                               work_->is_waiting ? 1.0 : 0.0};
    for (const FieldSize& field : work_->fields)
        for (const double* value : saved_of(field)) values.push_back(*value);
    for (const std::vector<double>* part : {&work_->wave_local, &work_->wave_error})
        values.insert(values.end(), part->begin(), part->end());
    for (const Spectra* spectra : saved_spectra(*work_))
        for (const Complex value : spectra->values) {
            values.push_back(value.real());
            values.push_back(value.imag());
        }
    return values;
}

void StepError::restore(std::span<const double> values) {
    require(values.size() == saved_numbers(), {}, "the checkpoint contains {} numbers of the step error; expected {}",
            values.size(), saved_numbers());
    auto next = values.begin();
    work_->stride = static_cast<std::int64_t>(*next++);
    work_->since = static_cast<std::int64_t>(*next++);
    work_->last_moment = static_cast<std::int64_t>(*next++);
    work_->steps = static_cast<std::int64_t>(*next++);
    work_->taken = static_cast<std::int64_t>(*next++);
    work_->leap = static_cast<std::int64_t>(*next++);
    work_->perturbation_growth = *next++;
    work_->alignment = *next++;
    work_->turn_rate = *next++;
    work_->unforeseen = *next++;
    work_->follows = *next++ != 0.0;
    work_->effort.spent = *next++;
    work_->checks.spent = *next++;
    work_->is_lost = *next++ != 0.0;
    work_->is_waiting = *next++ != 0.0;
    work_->from.step = 0.0;
    for (FieldSize& field : work_->fields)
        for (double* value : saved_of(field)) *value = *next++;
    for (std::vector<double>* part : {&work_->wave_local, &work_->wave_error})
        for (double& value : *part) value = *next++;
    for (Spectra* spectra : saved_spectra(*work_))
        for (Complex& value : spectra->values) {
            const double real = *next++;
            value = {real, *next++};
        }
}

}  // namespace drover::numerics
