// numerics/step_error.cpp: the tangent equations of the fields on a coarse grid, driven by measured local errors.
#include "drover/numerics/step_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "drover/base/random.hpp"
#include "drover/numerics/shells.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/wavenumbers.hpp"
#include "numerics/coarse_error.hpp"
#include "numerics/local_errors.hpp"

namespace drover::numerics {

namespace {
/// At most this many steps of the run in one of the error, which costs four right-hand sides on the coarse grid.  Fewer
/// where the explicit terms change the error by more than 0.3: the error of advected waves would grow by itself.
constexpr std::int64_t max_stride = 8;
constexpr std::int64_t min_strides = 8;  // in the run so far: a short run has an error, too
constexpr double max_change = 0.3;       // of the error by the explicit terms, in one of its steps
/// A step of the run that is longer is taken in parts: dt may be an output interval, which a method divides.
constexpr int max_parts = 64;

/// Random errors of noisy steps are measured too large: on 60 random scenes with noise the estimate without this factor
/// was 1.5 times the error in the median (tests/bench/step_error).
constexpr double random_errors = 0.7;
}  // namespace

struct StepError::Work {
    ErrorEquations equations;
    Grid fine, coarse;
    double dt;
    bool divides;
    std::int64_t stride = 1, since = 0;  // steps of the run in one of the error, and since its last
    double perturbation_growth = 0.0;    // |N(a + e) - N(a)|/|e|
    Threads one{1};
    std::vector<ModePair> shared, sampled;
    std::vector<FieldSize> fields;
    std::vector<FastWave> waves;                 // without noise
    std::vector<double> wave_local, wave_error;  // as error.values: the last local error, and the sum of all so far
    Spectra rate_before;                         // the explicit terms at the start of a step that is repeated in halves
    std::optional<Stepper> turn;                 // the linear part alone, over a part of a step
    Spectra error, shifted, rate;
    // At the ends of a step of the error and, if it is taken in parts, at a time between them.  Fields held at one of
    // the ends would change the growth of errors: those of the phase of an oscillation would decay.
    Reference from, to, between;
    double error_step = 0.0;
    LocalErrors local;
    Spectra drive, driven;  // the local error, without noise per time, and its sum over the steps since the last
    decltype(System::nonlinear) remainder;  // N
    System system;
    std::map<double, Stepper> steppers;  // by their steps over dt: a stride, or one over a number of parts
    bool noisy;

    Work(const ErrorEquations& the_equations, const Grid& grid, double the_dt, bool the_divides);
    void set_equations();
    Reference& reference_at(double t);
    void perturbation_rate(double t, const Spectra& perturbation, Spectra& out);
    double size_of(const Spectra& spectra, const FieldSize& field) const { return field.size_of(spectra, coarse); }
    void measure_fluctuations(const Spectra& fine_fields) {
        for (FieldSize& field : fields) field.add_moment(fine_fields, fine, noisy);
    }
    double wave_size(const FieldSize& field) const;
    double relative_size(const Spectra& spectra) const;
    double local_size() const;
    Spectra error_now() const;
    double growth() const;
    double size_without_phase(const FieldSize& field) const;
    void sample(const Spectra& fine_fields, Reference& into);
    Stepper& stepper(double steps);
    void evolve(std::int64_t step);
    void add_unresolved_waves(const Spectra& after);
    void add_random_errors(std::int64_t step, std::uint64_t number);
    void leave_out_direction();
    void bound();
};

StepError::Work::Work(const ErrorEquations& the_equations, const Grid& grid, double the_dt, bool the_divides)
    : equations(the_equations),
      fine(grid),
      coarse(coarse_grid(grid, the_equations.noisy ? 1 : the_equations.degree, the_equations.shortest)),
      dt(the_dt),
      divides(the_divides),
      noisy(the_equations.noisy) {
    shared = shared_modes(coarse, noisy ? 1 : equations.degree, fine, equations.degree);
    sampled = noisy ? sampled_modes(coarse, fine, equations.degree) : shared;
    for (const ErrorEquations::Field& field : equations.fields)
        fields.push_back({.first = field.first, .count = field.components, .name = field.name});
    set_equations();
    error = Spectra(coarse, components(system.layout));
    shifted = rate = local.last = local.before = drive = driven = error;
    for (Reference* reference : {&from, &to, &between}) reference->fields = reference->rate = error;
    wave_local.resize(error.values.size());
    wave_error.resize(error.values.size());
}

void StepError::Work::set_equations() {
    system = equations.on_grid(coarse, noisy, one);
    system.noise = {};
    system.product_noise = {};
    remainder = std::move(system.nonlinear);
    system.nonlinear = [this](double t, const Spectra& perturbation, Spectra& out) {
        perturbation_rate(t, perturbation, out);
    };
    steppers.clear();
    from.step = 0.0;
    double per_length = INFINITY;  // of the coarser axis; a one-dimensional grid has one
    if (coarse.nx > 1) per_length = coarse.nx / coarse.lx;
    if (coarse.ny > 1) per_length = std::min(per_length, coarse.ny / coarse.ly);
    const double cut = 2.0 * std::numbers::pi / (system.degree + 1) * per_length;
    if (!noisy) waves = fast_waves(system, coarse, system.degree, dt);
    if (divides)
        for (FastWave& wave : waves) wave.is_unresolved = false;
    turn.reset();
    if (!waves.empty()) {
        System linear = system;
        linear.nonlinear = {};
        turn.emplace(linear, stepper_table("etdrk2"), dt / 4.0, 0, one);
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

Reference& StepError::Work::reference_at(double t) {
    const double part = (t - from.t) / (to.t - from.t);
    constexpr double rounding = 1e-6;
    if (part < rounding) return from;
    if (part > 1.0 - rounding) return to;
    if (between.step > 0.0 && between.t == t) return between;
    for (std::size_t k = 0; k < error.values.size(); ++k)
        between.fields.values[k] = (1.0 - part) * from.fields.values[k] + part * to.fields.values[k];
    between.t = t;
    between.step = 0.0;
    return between;
}

/// N(a + e) - N(a), plus the local errors.  A small e is enlarged for the difference: its digits would be lost.
void StepError::Work::perturbation_rate(double t, const Spectra& perturbation, Spectra& out) {
    const auto begin = [&] {
        if (noisy) std::fill(out.values.begin(), out.values.end(), Complex(0.0));
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
        begin();
    }
}

double StepError::Work::wave_size(const FieldSize& field) const {
    double sum = 0.0;
    for (int c = field.first; c < field.first + field.count; ++c)
        for (const FastWave& wave : waves)
            sum += mode_weight(coarse, wave.mode % columns(coarse)) *
                   std::pow(wave_error[static_cast<std::size_t>(c) * error.size + wave.mode], 2.0);
    return std::sqrt(sum);
}

/// The size of an error on the coarse grid, of all fields.
double StepError::Work::relative_size(const Spectra& spectra) const {
    double sum = 0.0;
    for (const FieldSize& field : fields) sum += std::pow(ratio(size_of(spectra, field), field.scale()), 2.0);
    return std::sqrt(sum);
}

/// The size of the last local error, of all fields.
double StepError::Work::local_size() const {
    double sum = 0.0;
    for (const FieldSize& field : fields) sum += std::pow(ratio(field.local, field.scale()), 2.0);
    return std::sqrt(sum);
}

/// Under noise the errors of different steps are independent, of either sign: they add up as a random walk.  Half of
/// them are added before the error evolves, half after it: number 0 and 1.
void StepError::Work::add_random_errors(std::int64_t step, std::uint64_t number) {
    if (!noisy) return;
    double uniform = 0.0;
    fill_uniform({.seed = 0, .stream = Stream::step_error, .step = static_cast<std::uint64_t>(step)}, number, 1,
                 {&uniform, 1});
    const double factor = (uniform < 0.5 ? -1.0 : 1.0) * std::sqrt(0.5 * static_cast<double>(stride));
    for (std::size_t k = 0; k < error.values.size(); ++k) error.values[k] += factor * drive.values[k];
}

void StepError::Work::leave_out_direction() {
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
void StepError::Work::bound() {
    const double relative = relative_size(error);
    if (relative <= 1.0) return;
    for (Complex& value : error.values) value = std::isfinite(relative) ? value / relative : Complex(0.0);
}

StepError::StepError(const ErrorEquations& equations, const Grid& grid, double dt, bool divides)
    : work_(std::make_unique<Work>(equations, grid, dt, divides)) {}
StepError::~StepError() = default;
StepError::StepError(StepError&&) noexcept = default;

void StepError::set_equations(const ErrorEquations::OnGrid& on_grid) {
    work_->equations.on_grid = on_grid;
    work_->set_equations();
}

void StepError::add_local(const Spectra& local, const Spectra& fields) {
    Work& w = *work_;
    std::fill(w.shifted.values.begin(), w.shifted.values.end(), Complex(0.0));
    for (int c = 0; c < w.shifted.count(); ++c)
        for (const ModePair& pair : w.shared) w.shifted[c][pair.coarse] = local[c][pair.fine];
    for (std::size_t k = 0; k < w.wave_local.size(); ++k) w.wave_local[k] = std::abs(w.shifted.values[k]);
    w.add_unresolved_waves(fields);
    w.measure_fluctuations(fields);
    double before = 0.0, now = 0.0;  // in the same units: what an oscillation has passes from field to field
    for (FieldSize& field : w.fields) {
        before += std::pow(ratio(field.local, field.fluctuation()), 2.0);
        field.local = field.size_of(local, w.fine);
        field.local_low = w.size_of(w.shifted, field);
        now += std::pow(ratio(field.local, field.fluctuation()), 2.0);
    }
    w.local.add(w.shifted, std::sqrt(now), std::sqrt(before), w.fields, w.coarse);
    w.bound();
}

void StepError::continue_local(double intervals) {
    Work& w = *work_;
    if (w.noisy) {
        w.drive.values = w.local.last.values;
        return;
    }
    w.local.predict(intervals, w.drive);
    for (Complex& value : w.drive.values) value /= w.dt;
}

/// The fields at the points of the coarse grid.
void StepError::Work::sample(const Spectra& fine_fields, Reference& into) {
    Spectra& state = into.fields;
    into.step = 0.0;
    std::fill(state.values.begin(), state.values.end(), Complex(0.0));
    for (int c = 0; c < state.count(); ++c)
        for (const ModePair& pair : sampled)
            state[c][pair.coarse] += pair.conjugate ? std::conj(fine_fields[c][pair.fine]) : fine_fields[c][pair.fine];
}

void StepError::start_local(const Spectra& before) {
    Work& w = *work_;
    if (w.fields.front().moments == 0.0) {
        w.measure_fluctuations(before);
        w.sample(before, w.from);
    }
    if (w.waves.empty()) return;
    w.sample(before, w.between);
    if (w.rate_before.size == 0) w.rate_before = w.between.fields;
    try {
        w.remainder(0.0, w.between.fields, w.rate_before);
    } catch (const Error&) {  // a density that only the fine grid resolves
        w.rate_before = Spectra();
    }
}

/// The explicit terms of a wave that turns within a step change as fast as it does.  Half a step does not resolve that
/// either, so that their change over the step, and what the wave makes of it as it turns, is the local error.
void StepError::Work::add_unresolved_waves(const Spectra& after) {
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
        turn->step(0.0, 0, rate);
        for (int c = 0; c < rate.count(); ++c)
            for (const FastWave& wave : waves) {
                if (!wave.is_unresolved) continue;
                double& largest = wave_local[static_cast<std::size_t>(c) * rate.size + wave.mode];
                largest = std::max(largest, std::abs(rate[c][wave.mode]));
            }
    }
}

Stepper& StepError::Work::stepper(double steps) {
    const auto found = steppers.find(steps);
    if (found != steppers.end()) return found->second;
    return steppers.emplace(steps, Stepper(system, stepper_table("etdrk2"), steps * dt, 0, one)).first->second;
}

/// The error over the steps since it last evolved, in as many parts as its explicit terms need.
void StepError::Work::evolve(std::int64_t step) {
    const Spectra before = error;
    const double strides = static_cast<double>(stride);
    from.t = static_cast<double>(step - stride) * dt;
    to.t = static_cast<double>(step) * dt;
    for (int parts = 1;; parts *= 2) {
        const bool is_coarse = perturbation_growth * strides * dt > max_change * parts;
        if (is_coarse && parts < max_parts && stride == 1) continue;
        error.values = before.values;
        if (stride == 1 && perturbation_growth * dt > 2.0 * max_change * max_parts) {
            // An interval of outputs, much longer than the steps of its method: the errors of such intervals add up.
            for (std::size_t k = 0; k < error.values.size(); ++k) error.values[k] += dt * driven.values[k];
            return;
        }
        perturbation_growth = 0.0;
        double fastest = 0.0;
        between.step = 0.0;
        error_step = strides / parts * dt;
        for (int part = 0; part < parts; ++part) {
            const double t = from.t + (to.t - from.t) * part / parts;
            stepper(strides / parts).step(t, static_cast<std::uint64_t>(part), error);
            fastest = std::max(fastest, perturbation_growth);
        }
        perturbation_growth = fastest;
        if (stride > 1 || fastest * dt <= 2.0 * max_change * parts) return;
    }
}

void StepError::advance(std::int64_t step, const Spectra& fields) {
    Work& w = *work_;
    for (int c = 0; c < w.error.count(); ++c)
        for (const FastWave& wave : w.waves) {
            const std::size_t k = static_cast<std::size_t>(c) * w.error.size + wave.mode;
            w.wave_error[k] = wave.kept * w.wave_error[k] + w.wave_local[k];
        }
    for (std::size_t k = 0; k < w.driven.values.size(); ++k) w.driven.values[k] += w.drive.values[k];
    if (++w.since < w.stride) return;
    const bool has_start = w.fields.front().moments > 0.0;
    w.measure_fluctuations(fields);
    w.sample(fields, w.to);
    if (!has_start) w.from.fields = w.to.fields;
    for (Complex& value : w.driven.values) value /= static_cast<double>(w.since);
    w.add_random_errors(step, 0);
    w.evolve(step);
    w.add_random_errors(step, 1);
    w.leave_out_direction();
    w.bound();
    std::swap(w.from, w.to);
    std::fill(w.driven.values.begin(), w.driven.values.end(), Complex(0.0));
    w.since = 0;
    w.stride = max_stride;
    while (w.stride > 1 &&
           (min_strides * w.stride > step || w.perturbation_growth * static_cast<double>(w.stride) * w.dt > max_change))
        w.stride /= 2;
}

/// The error with those of the steps since it last evolved.
Spectra StepError::Work::error_now() const {
    Spectra now = error;
    if (!noisy)
        for (std::size_t k = 0; k < now.values.size(); ++k) now.values[k] += dt * driven.values[k];
    return now;
}

/// How much the error of earlier steps adds to that of the last.
double StepError::Work::growth() const {
    double low = 0.0;
    for (const FieldSize& field : fields) low += std::pow(ratio(field.local_low, field.scale()), 2.0);
    return low > 0.0 ? relative_size(error) / std::sqrt(low) : 1.0;
}

/// The size of the part of an error beyond the coarse grid, and of fast waves.
double StepError::Work::size_without_phase(const FieldSize& field) const {
    const double high = std::min(growth(), noisy ? std::sqrt(field.memory) : field.memory) * field.local_high();
    return std::hypot(wave_size(field), high);
}

StepError::Relative StepError::largest() const {
    const Work& w = *work_;
    const Spectra error = w.error_now();
    Relative result{.error = 0.0, .field = w.fields.front().name};
    for (const FieldSize& field : w.fields) {
        // Of the last step nothing has decayed yet.
        const double size = std::max(field.local, std::hypot(w.size_of(error, field), w.size_without_phase(field)));
        const double relative = (w.noisy ? random_errors : 1.0) * ratio(size, field.fluctuation());
        if (relative > result.error) result = {std::min(relative, 1.0), field.name};
    }
    return result;
}

std::optional<Spectra> StepError::known() const {
    const Work& w = *work_;
    constexpr double definite = 0.5;  // of the fluctuation
    if (w.noisy || largest().error > definite) return std::nullopt;
    const Spectra now = w.error_now();
    Spectra result(w.fine, now.count());
    for (const FieldSize& field : w.fields)
        if (w.size_without_phase(field) > w.size_of(now, field)) return std::nullopt;
    for (int c = 0; c < now.count(); ++c)
        for (const ModePair& pair : w.shared) result[c][pair.fine] = now[c][pair.coarse];
    return result;
}

double StepError::turn() const { return work_->local.angle; }

bool StepError::follows_phases(std::int64_t steps) const {
    const Work& w = *work_;
    constexpr double parted = 0.5, negligible = 0.1;
    if (w.noisy || largest().error > parted) return false;
    return static_cast<double>(steps) * w.local_size() > negligible * w.relative_size(w.error);
}

StepError::Relative StepError::largest_local() const {
    Relative result{.error = 0.0, .field = work_->fields.front().name};
    for (const FieldSize& field : work_->fields)
        if (const double error = ratio(field.local, field.scale()); !(error <= result.error))
            result = {error, field.name};
    return result;
}

namespace {
/// The saved numbers of a field.
template <class Field>
auto saved_of(Field& field) {
    return std::array{&field.size,    &field.largest,  &field.local,    &field.local_low, &field.moments,
                      &field.squares, &field.means[0], &field.means[1], &field.variance};
}
constexpr std::size_t saved_of_field = 9;
}  // namespace

std::size_t StepError::saved_numbers() const {
    return 3 + saved_of_field * work_->fields.size() + 12 * work_->error.values.size();
}

std::vector<double> StepError::save() const {
    std::vector<double> values{static_cast<double>(work_->stride), static_cast<double>(work_->since),
                               work_->perturbation_growth};
    for (const FieldSize& field : work_->fields)
        for (const double* value : saved_of(field)) values.push_back(*value);
    for (const std::vector<double>* part : {&work_->wave_local, &work_->wave_error})
        values.insert(values.end(), part->begin(), part->end());
    for (const Spectra* spectra :
         {&work_->error, &work_->local.last, &work_->drive, &work_->driven, &work_->from.fields})
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
    work_->perturbation_growth = *next++;
    work_->from.step = 0.0;
    for (FieldSize& field : work_->fields)
        for (double* value : saved_of(field)) *value = *next++;
    for (std::vector<double>* part : {&work_->wave_local, &work_->wave_error})
        for (double& value : *part) value = *next++;
    for (Spectra* spectra : {&work_->error, &work_->local.last, &work_->drive, &work_->driven, &work_->from.fields})
        for (Complex& value : spectra->values) {
            const double real = *next++;
            value = {real, *next++};
        }
}

}  // namespace drover::numerics
