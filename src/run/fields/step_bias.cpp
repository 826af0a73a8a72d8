// run/fields/step_bias.cpp: twins of pieces of a run, and fields less their estimated error.
#include "run/fields/step_bias.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "drover/base/error.hpp"

namespace drover::run {

namespace {
/// A piece is observed at so many equally spaced times; the first quarter of it is left out, the second is the early
/// half of what is compared with the last two: whether the difference still grows.
constexpr std::int64_t moments = 8;
constexpr std::int64_t min_length = 2 * moments;  // of a piece, in steps
/// In steps of the run, measured: of a step of dt by the twin, and once of the blocks of the twin.
constexpr double twin_steps = 2.0, start_steps = 50.0;
/// Of accuracy.effort; the rest, with noise, is for what is not counted, as what is written.  With noise the error of
/// the fields needs few steps, and the twins need many.
struct Shares {
    double step_error, biases;
};
Shares shares_of_effort(const io::Scene& scene) { return io::has_noise(scene) ? Shares{0.35, 0.5} : Shares{0.8, 0.2}; }
}  // namespace

StepBias::StepBias(const BiasedRun& run)
    : run_(run),
      noisy_(io::has_noise(run.scene)),
      effort_{.part = shares_of_effort(run.scene).biases * run.scene.accuracy.effort},
      observer_(observer_of_state(run.observer, run.threads)),
      early_(observer_->values(), 0.0),
      late_(early_) {}

/// The values of all observables, one after another.
std::vector<double> StepBias::observe(std::int64_t step, const numerics::Spectra& state) {
    if (fields_.count() == 0) {
        fields_ = numerics::Fields(run_.scene.grid, components());
        balanced_ = numerics::Fields(run_.scene.grid, static_cast<int>(run_.problem.balanced.size()));
    }
    const double time = static_cast<double>(step) * run_.scene.time.dt;
    run_.transform.backward(state, fields_);
    find_balanced(run_.evolution, time, state, balanced_);
    std::vector<double> values;
    for (const std::vector<double>& row :
         observer_->measure({.time = time, .spectra = state, .fields = fields_, .balanced = balanced_}))
        values.insert(values.end(), row.begin(), row.end());
    return values;
}

/// Of the observables of two states.
double StepBias::work_of_comparison() const { return 2.0 * numerics::work_of_observing(run_.scene.grid, components()); }

void StepBias::make_twin() {
    const io::TimeControl& time = run_.scene.time;
    twin_ = std::make_unique<model::FieldEvolution>(
        run_.problem.integrated, run_.scene.grid,
        numerics::StepControl{.method = time.stepper, .dt = 0.5 * time.dt, .tolerance = 0.0, .watches_error = false},
        static_cast<std::uint64_t>(run_.scene.run.seed), run_.threads);
}

void StepBias::begin_piece(std::int64_t step, const numerics::Spectra& state) {
    constexpr double part = 1.0 / 8.0;  // of what the steps so far allow
    // Without that of the start, which would be one piece longer than many runs.
    const double allowed = std::min(2.0 * effort_.part * effort_.done, effort_.allowed()),
                 work_a_step = effort_.done / static_cast<double>(step), steps = allowed / work_a_step;
    if (effort_.spent == 0.0) effort_.spent = start_steps * work_a_step;
    const auto next = moments * std::max(min_length / moments,
                                         static_cast<std::int64_t>(part * steps / static_cast<double>(moments)));
    const double work =
        twin_steps * static_cast<double>(next) * work_a_step + static_cast<double>(moments) * work_of_comparison();
    if (allowed - effort_.spent < work) return;
    if (!twin_) make_twin();
    begin_ = step;
    length_ = next;
    effort_.spent += work;
    twin_state_ = state;
    twin_->follow(run_.evolution);
    std::ranges::fill(early_, 0.0);
    std::ranges::fill(late_, 0.0);
}

void StepBias::advance_piece(std::int64_t step, const numerics::Spectra& state) {
    try {
        twin_->advance(2 * step - 2, twin_state_);
        twin_->advance(2 * step - 1, twin_state_);
    } catch (const Error& error) {
        if (error.fault() != Fault::run) throw;
        length_ = 0;  // the run itself reports a density that fails
        return;
    }
    const std::int64_t moment = (step - begin_) * moments / length_;
    if ((step - begin_) * moments % length_ != 0 || moment <= moments / 4) return;
    const std::vector<double> of_run = observe(step, state), of_twin = observe(step, twin_state_);
    const bool is_late = moment > moments / 2;
    std::vector<double>& sums = is_late ? late_ : early_;
    const double weight = 1.0 / static_cast<double>(is_late ? moments / 2 : moments / 4);
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += weight * (of_run[k] - of_twin[k]);
    if (moment < moments) return;
    completed_ = step;
    completed_length_ = length_;
    length_ = 0;
}

/// The observables of a state less those of the state without its error; NaN where the error is not known well enough.
std::vector<std::vector<double>> StepBias::compare(const numerics::Spectra& state) {
    std::vector<double> differences(early_.size(), now_ == 0 ? 0.0 : NAN);
    if (now_ == 0) return {{1.0}, differences, differences};                               // no step yet
    if (!effort_.affords(work_of_comparison())) return {{0.0}, differences, differences};  // at the end of a run
    effort_.spent += work_of_comparison();
    if (std::optional<numerics::Spectra> corrected = run_.evolution.known_error()) {
        for (std::size_t k = 0; k < corrected->values.size(); ++k)
            corrected->values[k] = state.values[k] - corrected->values[k];
        try {
            differences = observe(0, state);
            const std::vector<double> exact = observe(0, *corrected);
            for (std::size_t k = 0; k < differences.size(); ++k) differences[k] -= exact[k];
        } catch (const Error& error) {  // a density that the correction makes negative
            if (error.fault() != Fault::run) throw;
            std::ranges::fill(differences, NAN);
        }
    }
    return {{1.0}, differences, differences};
}

void StepBias::advance(std::int64_t step, const numerics::Spectra& state) {
    now_ = step;
    effort_.done = run_.evolution.work_done();
    if (!noisy_) return;
    if (length_ > 0) advance_piece(step, state);
    if (length_ == 0 && completed_ != step) begin_piece(step, state);  // the sums are recorded first
}

ScheduledRecording StepBias::recording(const numerics::Spectra& state) {
    std::vector<double> numbers(early_.size());
    std::iota(numbers.begin(), numbers.end(), 0.0);
    files::Recording recording{
        .group = step_bias_group,
        .axes = {{"value", "1", "values of all observables, one after another, in their order", numbers}},
        .quantities = {{"steps", "1", "length of the piece that ends here, in steps; 0: none ends here", {}},
                       {"late",
                        "1",
                        "value of the run less that of its twin, mean over the last half of the piece; "
                        "without noise less that of the fields without their estimated error",
                        {"value"}},
                       {"early", "1", "the same, mean over the second quarter of the piece", {"value"}}},
        .rows_per_chunk = 8};
    if (noisy_)
        return {
            .recording = std::move(recording),
            .observe =
                [this] {
                    const bool ends = completed_ == now_;  // not where a run ends within a piece
                    return store_in_place(row_, {{ends ? static_cast<double>(completed_length_) : 0.0}, late_, early_});
                },
            .due = [this](std::int64_t step) { return completed_ == step; }};
    const std::int64_t samples = io::whole_steps(run_.scene, "output.sample_every", run_.scene.output.sample_every);
    // Ever later: errors rise and fall at the start, and what may be spent there is soon spent.
    const auto observe = [this, &state] {
        constexpr std::int64_t per_doubling = 8;
        completed_ = now_;
        next_ = now_ + std::max<std::int64_t>(1, now_ / per_doubling);
        return store_in_place(row_, compare(state));
    };
    const auto due = [this, samples](std::int64_t step) {
        if (step == 0 || step == completed_) return true;
        return samples > 0 && step % samples == 0 && step >= next_ && effort_.affords(work_of_comparison());
    };
    return {.recording = std::move(recording), .observe = observe, .due = due};
}

std::vector<double> StepBias::save() const {
    std::vector<double> values{
        static_cast<double>(begin_),     static_cast<double>(length_),           effort_.spent,
        static_cast<double>(completed_), static_cast<double>(completed_length_), static_cast<double>(next_)};
    for (const auto* sums : {&early_, &late_}) values.insert(values.end(), sums->begin(), sums->end());
    if (length_ == 0) return values;
    const std::vector<double> evolution = twin_->save();
    for (const std::span<const double> part : {numerics::parts_of(twin_state_.values), std::span(evolution)})
        values.insert(values.end(), part.begin(), part.end());
    return values;
}

void StepBias::restore(std::span<const double> values) {
    const std::size_t sums = early_.size(), fixed = 6, complete = fixed + 2 * sums,
                      modes = 2 * numerics::Spectra(run_.scene.grid, components()).values.size();
    require(values.size() == complete || values.size() > complete + modes, {},
            "the checkpoint contains {} numbers of the step bias; expected {}, or more than {}; use the other "
            "checkpoint",
            values.size(), complete, complete + modes);
    begin_ = static_cast<std::int64_t>(values[0]);
    length_ = static_cast<std::int64_t>(values[1]);
    effort_.spent = values[2];
    completed_ = static_cast<std::int64_t>(values[3]);
    completed_length_ = static_cast<std::int64_t>(values[4]);
    next_ = static_cast<std::int64_t>(values[5]);
    const auto from = [&](std::size_t first) { return values.begin() + static_cast<std::ptrdiff_t>(first); };
    std::copy(from(fixed), from(fixed + sums), early_.begin());
    std::copy(from(fixed + sums), from(complete), late_.begin());
    if (values.size() == complete) return;
    twin_state_ = numerics::Spectra(run_.scene.grid, components());
    std::ranges::copy(values.subspan(complete, modes), numerics::parts_of(twin_state_.values).begin());
    make_twin();
    twin_->restore(values.subspan(complete + modes));
}

double effort_of_estimates(const io::Scene& scene) {
    return scene.accuracy.effort > 0.0 ? scene.accuracy.effort : io::Accuracy{}.effort;
}

double effort_of_step_error(const io::Scene& scene) {
    // Of a chosen step more: a false alarm costs a run.
    const double times = scene.found.step.by == io::ChosenBy::fields ? 5.0 : 1.0;
    return times * shares_of_effort(scene).step_error * effort_of_estimates(scene);
}

StepBiasState step_bias_state(const io::Scene& scene) {
    if (scene.accuracy.effort == 0.0) return StepBiasState::without_effort;
    if (!scene.accuracy.biases) return StepBiasState::not_measured;
    const bool noisy = io::has_noise(scene);
    if (noisy && scene.time.tolerance > 0.0) return StepBiasState::noise_and_tolerance;
    return !noisy && scene.time.max_error == 0.0 ? StepBiasState::without_max_error : StepBiasState::measured;
}

}  // namespace drover::run
