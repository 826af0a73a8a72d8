// numerics/steppers/error_evolution.cpp: the tangent equations of the fields on a coarse grid, driven by local errors.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/base/random.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/step_error.hpp"
#include "numerics/steppers/time_method.hpp"

namespace drover::numerics {

namespace {
/// At most this many steps of the run in one of the error, which costs three right-hand sides on the coarse grid; with
/// noise errors of steps add up at random, which needs steps.  Fewer where the explicit terms change the error by more
/// than 0.3: the error of advected waves would grow by itself.
constexpr std::int64_t max_stride = 64, max_noisy_stride = 8;
constexpr std::int64_t min_strides = 4, min_noisy_strides = 8;  // in the run so far: a short run has an error, too
constexpr double max_change = 0.3;  // of the error by the explicit terms, in one step of it of second order
/// For runs whose method divides steps: explicit terms may turn the shortest waves of the error by radians in a step,
/// where a method of second order lets them grow from nothing (|R|^2 = 1 + (w dt)^4/4).
constexpr const char* stable_on_waves = "etdrk4-krogstad";
constexpr double max_change_of_waves = 0.6;  // at the same cost
/// The same in a step of a run by a method of second order: the error may be taken as the fields are.
constexpr double largest_own_change = 1.0;
/// Parts of an error that grow show late, by longer steps than they allow: how fast terms were is forgotten slowly.
constexpr double forgotten = 0.9;
/// The fields' motion turns by at most this in one step of the error [radians], whose local error is constant.
constexpr double max_turn = 0.45;
/// Where the error costs more than it may, it takes a few steps, by which its fast parts relax, and leaps by its last
/// change, if it is small (projective integration): at most so many times the length of its step, since parts that
/// relax less fast would grow by longer leaps, by at most half of itself, and not where it turns.  Where that is not
/// enough its steps are longer, by at most this factor, unless they turn it, which would make it grow.  It is lost
/// where this is not enough either.
constexpr double largest_leap = 8.0, largest_change = 0.5, largest_turn = 0.1;
constexpr double largest_stretch = 4.0, aligned = 0.9;  // cosine between the error and its rate
constexpr double hasty_use = 0.6, lost_use = 1.3;       // of what is allowed
constexpr std::int64_t steps_before_leap = 3;
/// With noise the leap holds the error, which is what it will be sooner where its fast parts have relaxed; not where it
/// grows by more in one step.
constexpr double largest_growth = 1.2;
/// What the error takes beside right-hand sides: a step of it, and a local error [instructions for each component and
/// point of the coarse grid], what every local error does on the fine one, and the tables and arrays at the start, all
/// measured.
constexpr double work_of_value = 170.0, local_work = 100.0, fine_local_work = 12.0, start_work = 250.0;
/// A step of the run that is longer is taken in parts: dt may be an output interval, which a method divides.
constexpr int max_parts = 64;
}  // namespace

StepError::StepError(const ErrorEquations& the_equations, const Grid& grid, const StepControl& control)
    : equations(the_equations),
      fine{grid, the_equations.degree},
      coarse(coarse_grid(grid, the_equations.degree, the_equations.noisy, the_equations.shortest)),
      dt(control.dt),
      divides(control.tolerance > 0.0),
      own_change(time_method(control.method).order <= 2 && control.tolerance == 0.0 ? largest_own_change : 0.0),
      noisy(the_equations.noisy),
      is_short(control.steps <= first_steps) {
    shared = shared_modes(coarse, fine);
    sampled = noisy ? sampled_modes(coarse.grid, fine) : shared;
    for (const ErrorEquations::Field& field : equations.fields)
        fields.push_back({.first = field.first, .count = field.components, .name = field.name});
    set_equations();
    error = Spectra(coarse.grid, components(system.layout));
    shifted = rate = local.last = local.before = local.other = drive = driven = error;
    local.motion = local.other_motion = earlier = change = start = motion = motion_before = error;
    const double right_hand_sides = divides ? 6.6 : 3.3;  // half of fields, half of these with their error
    constexpr double part_of_checks = 0.5;                // of the effort
    effort.part = control.effort;
    checks.part = part_of_checks * control.effort;
    const double values = static_cast<double>(points(coarse.grid) * static_cast<std::size_t>(error.count())),
                 fine_values = static_cast<double>(points(grid) * static_cast<std::size_t>(error.count()));
    work_of_step = right_hand_sides * control.work.rate_a_point * weighed_points(coarse.grid) + work_of_value * values;
    work_of_local = local_work * values + fine_local_work * fine_values;
    effort.spent = checks.spent = start_work * fine_values;
    for (Reference* reference : {&from, &to, &between}) reference->fields = reference->rate = reference->motion = error;
    wave_local.resize(error.values.size());
    wave_error.resize(error.values.size());
}

void StepError::set_equations() {
    system = equations.on_grid(coarse.grid, coarse.degree, one);
    system.noise = {};
    system.product_noise = {};
    remainder = std::move(system.nonlinear);
    system.nonlinear = [this](double t, const Spectra& perturbation, Spectra& out) {
        perturbation_rate(t, perturbation, out);
    };
    linear.emplace(system);
    steppers.clear();
    from.step = 0.0;
    double per_length = INFINITY;  // of the coarser axis; a one-dimensional grid has one
    if (coarse.grid.nx > 1) per_length = coarse.grid.nx / coarse.grid.lx;
    if (coarse.grid.ny > 1) per_length = std::min(per_length, coarse.grid.ny / coarse.grid.ly);
    const double cut = 2.0 * std::numbers::pi / (system.degree + 1) * per_length;
    if (!noisy) waves = fast_waves(system, dt);
    if (divides)
        for (FastWave& wave : waves) wave.is_unresolved = false;
    linear_step.reset();
    if (!waves.empty()) {
        System linear = system;
        linear.nonlinear = {};
        linear_step.emplace(linear, stepper_table("etdrk2"), dt / 4.0, 0, one);
    }
    const IsotropicBlocks rates = system.linear(cut);
    const BlockParts parts = block_parts(system.layout);
    for (const auto& [block, members] : {std::pair{&rates.even, &parts.even}, std::pair{&rates.odd, &parts.odd}})
        for (int k = 0; k < block->size; ++k)
            for (FieldSize& field : fields) {
                if (field.first != (*members)[static_cast<std::size_t>(k)].component) continue;
                const double kept = std::exp((*block)(k, k) * dt * (noisy ? 2.0 : 1.0));
                field.memory = kept < 1.0 ? 1.0 / (1.0 - kept) : INFINITY;
            }
}

Reference& StepError::reference_at(double t) {
    const double part = (t - from.t) / (to.t - from.t);
    constexpr double rounding = 1e-6;
    if (part < rounding) return from;
    if (part > 1.0 - rounding) return to;
    if (between.step > 0.0 && between.t == t) return between;
    // The cubic with the rates at both ends.  A mode with rates far beyond what it moved has relaxed within the step.
    constexpr double fastest = 3.0;
    const double bump = part * (1.0 - part);
    for (std::size_t k = 0; k < error.values.size(); ++k) {
        const Complex a = from.fields.values[k], b = to.fields.values[k];
        between.fields.values[k] = (1.0 - part) * a + part * b;
        if (noisy) continue;
        const Complex at_first = (to.t - from.t) * from.motion.values[k] - (b - a),
                      at_last = (to.t - from.t) * to.motion.values[k] - (b - a);
        if (std::abs(at_first) + std::abs(at_last) <= fastest * (std::abs(a) + std::abs(b)))
            between.fields.values[k] += bump * ((1.0 - part) * at_first - part * at_last);
    }
    between.t = t;
    between.step = 0.0;
    return between;
}

/// Of the fields at both ends of a step.
void StepError::find_motion() {
    if (system.set_step) system.set_step(error_step);
    for (Reference* at : {&from, &to}) {
        std::ranges::fill(at->motion.values, Complex(NAN));  // compares as too fast
        try {
            if (at->step != error_step) remainder(at->t, at->fields, at->rate);
            at->step = error_step;
        } catch (const Error&) {  // a density that only the fine grid resolves
            continue;
        }
        at->motion.values = at->rate.values;
        linear->add(at->fields, at->motion);
    }
}

/// N(a + e) - N(a), plus the local errors.  A small e is enlarged for the difference: its digits would be lost.
void StepError::perturbation_rate(double t, const Spectra& perturbation, Spectra& out) {
    const auto begin = [&] {
        if (noisy) std::ranges::fill(out.values, Complex(0.0));
        else out.values = driven.values;
    };
    begin();
    const double relative = relative_size(perturbation);
    if (relative == 0.0 || !std::isfinite(relative)) return;
    const double enlarged = std::max(1.0, 1e-5 / relative);
    try {
        Reference& at = reference_at(t);
        if (at.step != error_step) {
            remainder(at.t, at.fields, at.rate);
            at.step = error_step;
        }
        for (std::size_t k = 0; k < out.values.size(); ++k)
            shifted.values[k] = at.fields.values[k] + enlarged * perturbation.values[k];
        remainder(at.t, shifted, rate);
        for (std::size_t k = 0; k < out.values.size(); ++k) {
            rate.values[k] = (rate.values[k] - at.rate.values[k]) / enlarged;
            out.values[k] += rate.values[k];
        }
        perturbation_growth = relative_size(rate) / relative;
    } catch (const Error&) {  // a density that only the fine grid resolves
        std::ranges::fill(rate.values, Complex(0.0));
        begin();
    }
}

/// The size of an error on the coarse grid, of all fields.
double StepError::relative_size(const Spectra& spectra) const {
    double sum = 0.0;
    for (const FieldSize& field : fields) sum += std::pow(ratio(size_of(spectra, field), field.scale()), 2.0);
    return std::sqrt(sum);
}

/// Under noise the errors of different steps are independent, of either sign: they add up as a random walk.  Half of
/// them are added before the error evolves, half after it: number 0 and 1.
void StepError::add_random_errors(std::int64_t step, std::uint64_t number) {
    if (!noisy) return;
    double uniform = 0.0;
    fill_uniform({.seed = 0, .stream = Stream::step_error, .step = static_cast<std::uint64_t>(step)}, number, 1,
                 {&uniform, 1});
    const double factor = (uniform < 0.5 ? -1.0 : 1.0) * std::sqrt(0.5 * static_cast<double>(stride));
    for (std::size_t k = 0; k < error.values.size(); ++k) error.values[k] += factor * drive.values[k];
}

void StepError::leave_out_direction() {
    if (!noisy || equations.turning.empty()) return;
    const int p = equations.turning.front();
    const double px = to.fields[p][0].real(), py = to.fields[p + 1][0].real(), size = std::hypot(px, py);
    if (size == 0.0) return;
    for (const int c : equations.turning) {
        const double across = (error[c + 1][0].real() * px - error[c][0].real() * py) / size;
        error[c][0] += across * py / size;
        error[c + 1][0] -= across * px / size;
    }
}

/// An error as large as the fields says only that they are unrelated; it must not overflow.
void StepError::bound() {
    const double relative = relative_size(error);
    if (relative <= 1.0) return;
    for (Complex& value : error.values) value = std::isfinite(relative) ? value / relative : Complex(0.0);
}

/// The explicit terms of a wave that turns within a step change as fast as it does.  Half a step does not resolve that
/// either, so that their change over the step, and what the wave makes of it as it turns, is the local error.
void StepError::add_unresolved_waves(const Spectra& after) {
    if (waves.empty() || rate_before.size == 0) return;
    sample(after, between);
    try {
        remainder(0.0, between.fields, rate);
    } catch (const Error&) {
        return;
    }
    for (std::size_t k = 0; k < rate.values.size(); ++k)
        rate.values[k] = 0.5 * dt * (rate.values[k] - rate_before.values[k]);
    for (int part = 0; part < 4; ++part) {
        linear_step->step(0.0, 0, rate);
        for (int c = 0; c < rate.count(); ++c)
            for (const FastWave& wave : waves) {
                if (!wave.is_unresolved) continue;
                double& largest = wave_local[static_cast<std::size_t>(c) * rate.size + wave.mode];
                largest = std::max(largest, std::abs(rate[c][wave.mode]));
            }
    }
}

Stepper& StepError::stepper(double steps) {
    const auto found = steppers.find(steps);
    if (found != steppers.end()) return found->second;
    return steppers
        .emplace(steps, Stepper(system, stepper_table(divides ? stable_on_waves : "etdrk2"), steps * dt, 0, one))
        .first->second;
}

double StepError::longest_change() const { return divides ? max_change_of_waves : max_change; }

/// The error over the steps since it last evolved, in as many parts as its explicit terms need.
void StepError::evolve(std::int64_t step) {
    const Spectra before = error;
    const double strides = static_cast<double>(stride);
    from.t = static_cast<double>(step - stride) * dt;
    to.t = static_cast<double>(step) * dt;
    for (int parts = 1;; parts *= 2) {
        const double change = perturbation_growth * strides * dt;
        const bool is_own_step = parts == 1 && change <= own_change;
        const bool is_coarse = change > longest_change() * stretch() * parts;
        if (is_coarse && !is_own_step && parts < max_parts && stride == 1) continue;
        error.values = before.values;
        if (stride == 1 && perturbation_growth * dt > 2.0 * longest_change() * max_parts) {
            // An interval of outputs, much longer than the steps of its method: the errors of such intervals add up.
            for (std::size_t k = 0; k < error.values.size(); ++k) error.values[k] += dt * driven.values[k];
            return;
        }
        const double growth_before = perturbation_growth;
        perturbation_growth = 0.0;
        double fastest = 0.0;
        between.step = 0.0;
        std::ranges::fill(rate.values, Complex(0.0));
        error_step = strides / parts * dt;
        if (!noisy && (divides || parts > 1)) find_motion();  // else the error is evaluated at the ends alone
        effort.spent += work_of_step * parts;
        for (int part = 0; part < parts; ++part) {
            const double t = from.t + (to.t - from.t) * part / parts;
            stepper(strides / parts).step(t, static_cast<std::uint64_t>(part), error);
            fastest = std::max(fastest, perturbation_growth);
        }
        perturbation_growth = std::max(fastest, forgotten * growth_before);
        alignment = fastest > 0.0 ? std::abs(std::cos(angle_between(rate, error, fields, coarse))) : 0.0;
        if (stride > 1 || fastest * dt <= std::max(2.0 * longest_change() * parts, parts == 1 ? own_change : 0.0))
            return;
    }
}

/// The local error turns and decays as the motion of the fields does.
void StepError::follow_motion() {
    if (noisy) return;
    for (std::size_t k = 0; k < motion.values.size(); ++k)
        motion.values[k] = (to.fields.values[k] - from.fields.values[k]) / static_cast<double>(stride);
    turn_rate = angle_between(motion, motion_before, fields, coarse) / static_cast<double>(stride);
    std::swap(motion, motion_before);
    follows = local.follow(motion_before, fields, coarse, shifted);
    if (!follows) return;
    for (std::size_t k = 0; k < drive.values.size(); ++k) drive.values[k] = shifted.values[k] / dt;
    driven.values = drive.values;
}

void StepError::choose_stride(std::int64_t step) {
    const double so_far = static_cast<double>(step) / static_cast<double>(noisy ? min_noisy_strides : min_strides);
    const double longest = std::min(
        {so_far, longest_change() * stretch() / (perturbation_growth * dt), noisy ? INFINITY : max_turn / turn_rate});
    stride = noisy ? max_noisy_stride : max_stride;
    while (stride > 1 && static_cast<double>(stride) > longest) stride /= 2;
}

/// By which its steps may be longer: 1 while the error costs less than it may, or turns.
double StepError::stretch() const {
    if (turn_rate * static_cast<double>(stride) > largest_turn || alignment < aligned) return 1.0;
    return std::clamp(1.0 + (largest_stretch - 1.0) * (effort.used() - hasty_use) / (1.0 - hasty_use), 1.0,
                      largest_stretch);
}

void StepError::choose_leap(std::int64_t step) {
    constexpr double parted = 0.5;
    const double size = relative_size(error), strides = static_cast<double>(stride), now = static_cast<double>(step);
    is_lost = size < parted && effort.spent > lost_use * effort.allowed() + 2.0 * owed_work();
    if (std::isinf(effort.part)) return;
    if (++taken < steps_before_leap && size < parted) return;
    // The length at which all that was taken costs what it may, and the next steps as well.
    const double next = work_of_step * static_cast<double>(steps_before_leap),
                 over = effort.spent + next - hasty_use * effort.allowed();
    if (over <= 0.0) return;
    double longest = over / effort.gain(work_of_run_step) - strides * static_cast<double>(steps_before_leap);
    longest = std::min(longest, std::max(64.0, now));
    for (std::size_t k = 0; k < error.values.size(); ++k)
        change.values[k] = size < parted && !noisy ? (error.values[k] - earlier.values[k]) / strides : Complex(0.0);
    if (noisy && size < parted) {
        if (size > largest_growth * relative_size(earlier)) return;
        longest = std::min(longest, std::max(largest_leap * strides, now / 8.0));
    } else if (size < parted) {
        longest = std::min(
            {longest, largest_leap * strides, largest_change * size / relative_size(change), largest_turn / turn_rate});
    }
    if (!(longest >= strides)) return;
    leap = static_cast<std::int64_t>(longest);
    taken = 0;
}

void StepError::end_leap(const Spectra& fine_fields) {
    for (std::size_t k = 0; k < error.values.size(); ++k)
        error.values[k] += static_cast<double>(leap) * change.values[k];
    bound();
    sample(fine_fields, from);
    leap = since = 0;
}

double StepError::wave_size(const FieldSize& field) const {
    double sum = 0.0;
    for (int c = field.first; c < field.first + field.count; ++c)
        for (const FastWave& wave : waves)
            sum += mode_weight(coarse.grid, wave.mode % columns(coarse.grid)) *
                   std::pow(wave_error[static_cast<std::size_t>(c) * error.size + wave.mode], 2.0);
    return std::sqrt(sum);
}

/// Sizes that are known of each field, as one of all.
double StepError::relative_size(double FieldSize::*of_field) const {
    double sum = 0.0;
    for (const FieldSize& field : fields) sum += std::pow(ratio(field.*of_field, field.scale()), 2.0);
    return std::sqrt(sum);
}

/// The fields at the points of the coarse grid.
void StepError::sample(const Spectra& fine_fields, Reference& into) {
    Spectra& state = into.fields;
    into.step = 0.0;
    std::ranges::fill(state.values, Complex(0.0));
    for (int c = 0; c < state.count(); ++c)
        for (const ModePair& pair : sampled)
            state[c][pair.coarse] += pair.conjugate ? std::conj(fine_fields[c][pair.fine]) : fine_fields[c][pair.fine];
}

/// The angle between the last local error and the present drive.
double StepError::angle_to_drive() const { return angle_between(shifted, drive, fields, coarse); }

/// The error with those of the steps since it last evolved.
Spectra StepError::error_now() const {
    Spectra now = error;
    const double leapt = leap > 0 ? static_cast<double>(since) : 0.0;
    if (!noisy)
        for (std::size_t k = 0; k < now.values.size(); ++k)
            now.values[k] += dt * driven.values[k] + leapt * change.values[k];
    return now;
}

/// The error over local errors: of the last step, or summed.
double StepError::growth(double FieldSize::*local) const {
    const double low = relative_size(local);
    return low > 0.0 ? relative_size(error) / low : 1.0;
}

void StepError::measure_fluctuations(const Spectra& fine_fields, double weight) {
    for (FieldSize& field : fields) {
        field.add_moment(fine_fields, fine, noisy, weight);
        double long_waves = 0.0;
        for (int c = field.first; c < field.first + field.count; ++c)
            for (const ModePair& pair : shared)
                long_waves +=
                    mode_weight(coarse.grid, pair.coarse % columns(coarse.grid)) * std::norm(fine_fields[c][pair.fine]);
        field.short_waves =
            std::max(forgotten * field.short_waves, std::sqrt(std::max(0.0, field.size * field.size - long_waves)));
    }
}

/// The size of the part of an error beyond the coarse grid, and of fast waves.  An explicit method whose steps are as
/// long as is stable makes large local errors of waves that hardly are there.
double StepError::size_without_phase(const FieldSize& field) const {
    double high = std::min(growth(&FieldSize::local_low), noisy ? std::sqrt(field.memory) : field.memory);
    high = std::min(high * field.local_high(), 2.0 * field.short_waves + field.local_high());
    if (!noisy) high = std::min(high, growth(&FieldSize::low_sum) * field.high_sum);
    return std::hypot(wave_size(field), high);
}

}  // namespace drover::numerics
