// numerics/steppers/step_error.cpp: the reported error of the time steps, and its state.
#include "numerics/steppers/step_error.hpp"

#include <algorithm>
#include <cmath>

namespace drover::numerics {

namespace {
/// Fields are measured so often in the run so far, and at each check.
constexpr std::int64_t min_moments = 64;

/// Of fields that are 0 at the start: of the local error, which ends a run, more than of the whole.
constexpr std::int64_t first_local_steps = 16;

/// Random errors of noisy steps are measured too large: on 60 random scenes with noise the estimate without this factor
/// was 1.5 times the error in the median (tests/bench/step_error).
constexpr double random_errors = 0.7;
}  // namespace

void StepError::set_equations(const ErrorEquations::OnGrid& on_grid) {
    equations.on_grid = on_grid;
    set_equations();
}

void StepError::add_local(const Spectra& of_step, const Spectra& state, double work, std::int64_t waited) {
    for (Effort* one : {&effort, &checks}) one->spent += work + work_of_local;
    std::ranges::fill(shifted.values, Complex(0.0));
    for (int c = 0; c < shifted.count(); ++c)
        for (const ModePair& pair : shared) shifted[c][pair.coarse] = of_step[c][pair.fine];
    for (std::size_t k = 0; k < wave_local.size(); ++k) wave_local[k] = std::abs(shifted.values[k]);
    add_unresolved_waves(state);
    measure_fluctuations(state, 0.0);
    double before = 0.0, now = 0.0;  // in the same units: what an oscillation has passes from field to field
    for (FieldSize& field : fields) {
        before += std::pow(ratio(field.local, field.fluctuation()), 2.0);
        field.local = field.size_of(of_step, fine);
        field.local_low = size_of(shifted, field);
        field.low_sum += static_cast<double>(waited) * field.local_low;
        field.high_sum += static_cast<double>(waited) * field.local_high();
        now += std::pow(ratio(field.local, field.fluctuation()), 2.0);
    }
    for (int c = 0; c < start.count(); ++c)
        for (const ModePair& pair : shared) start[c][pair.coarse] = state[c][pair.fine] - start[c][pair.coarse];
    unforeseen = angle_to_drive();
    // After a long wait: whether the errors that were added were others than those that were made, and matter.
    constexpr double unlike = 0.5, matters = 0.1;  // radians; of the error
    const bool is_unlike = is_waiting && unforeseen > unlike;
    is_lost = is_lost || (is_unlike && static_cast<double>(waited) * relative_size(&FieldSize::local) >
                                           matters * relative_size(error));
    is_waiting = false;
    local.add(shifted, start, std::sqrt(now), std::sqrt(before), fields, coarse);
    bound();
}

void StepError::continue_local(double intervals) {
    if (noisy) {
        drive.values = local.last.values;
        return;
    }
    if (follows) drive.values = local.last.values;
    else local.predict(intervals, drive);
    for (Complex& value : drive.values) value /= dt;
}

void StepError::start_local(const Spectra& before) {
    if (fields.front().moments == 0.0) {
        measure_fluctuations(before, 1.0);
        for (FieldSize& field : fields) field.start = field.size;
        sample(before, from);
    }
    for (FieldSize& field : fields) field.before = field.size_of(before, fine);
    for (int c = 0; c < start.count(); ++c)
        for (const ModePair& pair : shared) start[c][pair.coarse] = before[c][pair.fine];
    if (waves.empty()) return;
    sample(before, between);
    if (rate_before.size == 0) rate_before = between.fields;
    try {
        remainder(0.0, between.fields, rate_before);
    } catch (const Error&) {  // a density that only the fine grid resolves
        rate_before = Spectra();
    }
}

void StepError::advance(std::int64_t step, const Spectra& state) {
    steps = step;
    for (int c = 0; c < error.count(); ++c)
        for (const FastWave& wave : waves) {
            const std::size_t k = static_cast<std::size_t>(c) * error.size + wave.mode;
            wave_error[k] = wave.kept * wave_error[k] + wave_local[k];
        }
    ++since;
    if (is_lost) return;
    if (leap > 0) {
        if (since >= leap) end_leap(state);
        return;
    }
    for (std::size_t k = 0; k < driven.values.size(); ++k) driven.values[k] += drive.values[k];
    if (since < stride) return;
    const bool has_start = fields.front().moments > 0.0;
    if (min_moments * (step - last_moment) >= step) {
        measure_fluctuations(state, static_cast<double>(step - last_moment));
        last_moment = step;
    }
    sample(state, to);
    if (!has_start) from.fields = to.fields;
    for (Complex& value : driven.values) value /= static_cast<double>(since);
    follow_motion();
    earlier.values = error.values;
    add_random_errors(step, 0);
    evolve(step);
    add_random_errors(step, 1);
    leave_out_direction();
    bound();
    std::swap(from, to);
    std::ranges::fill(driven.values, Complex(0.0));
    since = 0;
    choose_leap(step);
    choose_stride(step);
}

void StepError::count_work(double done, double of_step) {
    effort.done = checks.done = done;
    work_of_run_step = of_step;
}

std::int64_t StepError::steps_to_afford(double work, std::int64_t max_steps) const {
    constexpr double part = 0.25;  // of what is left: the first steps may not take all
    if (std::isinf(checks.part)) return 1;
    const double left = checks.allowed() + owed_work() - checks.spent,
                 afforded = (work + work_of_local - part * left) / checks.gain(work_of_run_step);
    return static_cast<std::int64_t>(std::clamp(afforded, 1.0, static_cast<double>(max_steps)));
}

void StepError::wait() { is_waiting = true; }

StepError::Relative StepError::largest() const {
    if (is_lost || is_waiting) return {.error = NAN, .field = fields.front().name};
    const Spectra now = error_now();
    Relative result{.error = 0.0, .field = fields.front().name};
    for (const FieldSize& field : fields) {
        // Of the last step nothing has decayed yet.
        const double size = std::max(field.local, std::hypot(size_of(now, field), size_without_phase(field)));
        const double relative = (noisy ? random_errors : 1.0) * ratio(size, field.fluctuation());
        if (relative > result.error && (is_short || has_size(field, first_steps)))
            result = {std::min(relative, 1.0), field.name};
    }
    return result;
}

std::optional<Spectra> StepError::known() const {
    constexpr double definite = 0.5;  // of the fluctuation
    if (noisy || !(largest().error <= definite)) return std::nullopt;
    const Spectra now = error_now();
    Spectra result(fine.grid, now.count());
    for (const FieldSize& field : fields)
        if (size_without_phase(field) > size_of(now, field)) return std::nullopt;
    for (int c = 0; c < now.count(); ++c)
        for (const ModePair& pair : shared) result[c][pair.fine] = now[c][pair.coarse];
    return result;
}

double StepError::turn() const { return unforeseen; }

bool StepError::follows_phases(std::int64_t more) const {
    constexpr double parted = 0.5, negligible = 0.1;
    if (noisy || !(largest().error <= parted)) return false;
    return static_cast<double>(more) * relative_size(&FieldSize::local) > negligible * relative_size(error);
}

StepError::Relative StepError::largest_local() const {
    Relative result{.error = 0.0, .field = fields.front().name};
    for (const FieldSize& field : fields)
        // A field that noise takes through 0 is small after one step or two.
        if (const double relative = ratio(field.local, noisy ? std::max(field.scale(), field.before) : field.scale());
            !(relative <= result.error) && has_size(field, first_local_steps))
            result = {relative, field.name};
    return result;
}

/// visit(number) for each number of a checkpoint, in its order.  Self: const or not.
template <class Self, class Visit>
void StepError::for_saved(Self& self, Visit visit) {
    const auto all = [&](auto&... numbers) { (visit(numbers), ...); };
    all(self.stride, self.since, self.last_moment, self.steps, self.taken, self.leap, self.perturbation_growth,
        self.alignment, self.turn_rate, self.unforeseen, self.follows, self.effort.spent, self.checks.spent,
        self.is_lost, self.is_waiting);
    for (auto& field : self.fields)
        all(field.size, field.largest, field.start, field.local, field.local_low, field.low_sum, field.high_sum,
            field.short_waves, field.moments, field.squares, field.means[0], field.means[1], field.variance);
    for (auto* part : {&self.wave_local, &self.wave_error})
        for (auto& number : *part) visit(number);
    for (auto* spectra :
         {&self.error, &self.local.last, &self.local.before, &self.local.other, &self.local.motion,
          &self.local.other_motion, &self.drive, &self.driven, &self.from.fields, &self.change, &self.motion_before})
        for (auto& number : spectra->values) visit(number);
}

std::vector<double> StepError::save() const {
    std::vector<double> values;
    for_saved(*this, [&](const auto& number) {
        if constexpr (requires { number.real(); }) values.insert(values.end(), {number.real(), number.imag()});
        else values.push_back(static_cast<double>(number));
    });
    return values;
}

void StepError::restore(std::span<const double> values) {
    require(values.size() == saved_numbers(), {}, "the checkpoint contains {} numbers of the step error; expected {}",
            values.size(), saved_numbers());
    auto next = values.begin();
    for_saved(*this, [&](auto& number) {
        if constexpr (requires { number.real(); }) {
            const double real = *next++;
            number = {real, *next++};
        } else {
            number = static_cast<std::remove_reference_t<decltype(number)>>(*next++);
        }
    });
    from.step = 0.0;
}

}  // namespace drover::numerics
