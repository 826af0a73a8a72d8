// run/step_bias.cpp: twins of pieces of a run, and fields less their estimated error.
#include "run/step_bias.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/base/error.hpp"
#include "numerics/steppers/effort.hpp"
#include "run/grid_run.hpp"

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

struct StepBias::Work {
    io::Scene scene;
    BiasedRun run;
    bool noisy;
    numerics::Effort effort;

    // With noise: the twin, and its piece from step `begin` on; length 0: there is none now.
    std::optional<Twin> twin;
    numerics::Spectra twin_state;
    std::int64_t begin = 0, length = 0;
    std::vector<double> early, late;
    std::int64_t completed = -1, completed_length = 0;  // step at which the last piece ended
    // Without noise: the step now, and that of the next comparison at the earliest; the last one was at `completed`.
    std::int64_t now = 0, next = 0;
    std::vector<std::vector<double>> row;  // as recorded

    Work(const io::Scene& the_scene, BiasedRun the_run)
        : scene(the_scene),
          run(std::move(the_run)),
          noisy(io::has_noise(scene)),
          effort{.part = shares_of_effort(scene).biases * scene.accuracy.effort},
          early(run.values, 0.0),
          late(run.values, 0.0) {}
    std::vector<double> observe(std::int64_t step, const numerics::Spectra& state) const {
        return run.observe(static_cast<double>(step) * scene.time.dt, state);
    }
    /// Of the observables of two states.
    double work_of_comparison() const { return 2.0 * numerics::work_of_observing(scene.grid, run.components); }
    void begin_piece(std::int64_t step, const numerics::Spectra& state);
    void advance_piece(std::int64_t step, const numerics::Spectra& state);
    std::vector<std::vector<double>> compare(const numerics::Spectra& state);
};

void StepBias::Work::begin_piece(std::int64_t step, const numerics::Spectra& state) {
    constexpr double part = 1.0 / 8.0;  // of what the steps so far allow
    // Without that of the start, which would be one piece longer than many runs.
    const double allowed = std::min(2.0 * effort.part * effort.done, effort.allowed()),
                 work_a_step = effort.done / static_cast<double>(step), steps = allowed / work_a_step;
    if (effort.spent == 0.0) effort.spent = start_steps * work_a_step;
    const auto next = moments * std::max(min_length / moments,
                                         static_cast<std::int64_t>(part * steps / static_cast<double>(moments)));
    const double work =
        twin_steps * static_cast<double>(next) * work_a_step + static_cast<double>(moments) * work_of_comparison();
    if (allowed - effort.spent < work) return;
    if (!twin) twin = run.make_twin();
    begin = step;
    length = next;
    effort.spent += work;
    twin_state = state;
    twin->follow();
    std::fill(early.begin(), early.end(), 0.0);
    std::fill(late.begin(), late.end(), 0.0);
}

void StepBias::Work::advance_piece(std::int64_t step, const numerics::Spectra& state) {
    try {
        twin->advance(2 * step - 2, twin_state);
        twin->advance(2 * step - 1, twin_state);
    } catch (const Error& error) {
        if (error.fault() != Fault::run) throw;
        length = 0;  // the run itself reports a density that fails
        return;
    }
    const std::int64_t moment = (step - begin) * moments / length;
    if ((step - begin) * moments % length != 0 || moment <= moments / 4) return;
    const std::vector<double> of_run = observe(step, state), of_twin = observe(step, twin_state);
    const bool is_late = moment > moments / 2;
    std::vector<double>& sums = is_late ? late : early;
    const double weight = 1.0 / static_cast<double>(is_late ? moments / 2 : moments / 4);
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += weight * (of_run[k] - of_twin[k]);
    if (moment < moments) return;
    completed = step;
    completed_length = length;
    length = 0;
}

/// The observables of a state less those of the state without its error; NaN where the error is not known well enough.
std::vector<std::vector<double>> StepBias::Work::compare(const numerics::Spectra& state) {
    std::vector<double> differences(early.size(), now == 0 ? 0.0 : NAN);
    if (now == 0) return {{1.0}, differences, differences};                               // no step yet
    if (!effort.affords(work_of_comparison())) return {{0.0}, differences, differences};  // at the end of a run
    effort.spent += work_of_comparison();
    if (std::optional<numerics::Spectra> corrected = run.known_error()) {
        for (std::size_t k = 0; k < corrected->values.size(); ++k)
            corrected->values[k] = state.values[k] - corrected->values[k];
        try {
            differences = observe(0, state);
            const std::vector<double> exact = observe(0, *corrected);
            for (std::size_t k = 0; k < differences.size(); ++k) differences[k] -= exact[k];
        } catch (const Error& error) {  // a density that the correction makes negative
            if (error.fault() != Fault::run) throw;
            std::fill(differences.begin(), differences.end(), NAN);
        }
    }
    return {{1.0}, differences, differences};
}

StepBias::StepBias(const io::Scene& scene, BiasedRun run) : work_(std::make_unique<Work>(scene, std::move(run))) {}
StepBias::~StepBias() = default;

void StepBias::advance(std::int64_t step, const numerics::Spectra& state) {
    Work& w = *work_;
    w.now = step;
    w.effort.done = w.run.work_done();
    if (!w.noisy) return;
    if (w.length > 0) w.advance_piece(step, state);
    if (w.length == 0 && w.completed != step) w.begin_piece(step, state);  // the sums are recorded first
}

ScheduledRecording StepBias::recording(const std::shared_ptr<StepBias>& bias, const numerics::Spectra& state) {
    const Work& w = *bias->work_;
    std::vector<double> numbers;
    for (std::size_t k = 0; k < w.early.size(); ++k) numbers.push_back(static_cast<double>(k));
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
    if (w.noisy) {
        const auto observe = [bias] {
            Work& work = *bias->work_;
            const bool ends = work.completed == work.now;  // not where a run ends within a piece
            return lend(work.row, {{ends ? static_cast<double>(work.completed_length) : 0.0}, work.late, work.early});
        };
        ScheduledRecording scheduled{std::move(recording), 0, observe};
        scheduled.due = [bias](std::int64_t step) { return bias->work_->completed == step; };
        return scheduled;
    }
    const std::int64_t samples = io::whole_steps(w.scene, "output.sample_every", w.scene.output.sample_every);
    // Ever later: errors rise and fall at the start, and what may be spent there is soon spent.
    const auto observe = [bias, &state] {
        Work& work = *bias->work_;
        constexpr std::int64_t per_doubling = 8;
        work.completed = work.now;
        work.next = work.now + std::max<std::int64_t>(1, work.now / per_doubling);
        return lend(work.row, work.compare(state));
    };
    ScheduledRecording scheduled{std::move(recording), 0, observe};
    scheduled.due = [bias, samples](std::int64_t step) {
        const Work& work = *bias->work_;
        if (step == 0 || step == work.completed) return true;
        return samples > 0 && step % samples == 0 && step >= work.next &&
               work.effort.affords(work.work_of_comparison());
    };
    return scheduled;
}

std::vector<double> StepBias::save() const {
    const Work& w = *work_;
    std::vector<double> values{
        static_cast<double>(w.begin),     static_cast<double>(w.length),           w.effort.spent,
        static_cast<double>(w.completed), static_cast<double>(w.completed_length), static_cast<double>(w.next)};
    for (const auto* sums : {&w.early, &w.late}) values.insert(values.end(), sums->begin(), sums->end());
    if (w.length == 0) return values;
    append_numbers(w.twin_state, values);
    const std::vector<double> evolution = w.twin->save();
    values.insert(values.end(), evolution.begin(), evolution.end());
    return values;
}

void StepBias::restore(std::span<const double> values) {
    Work& w = *work_;
    const std::size_t sums = w.early.size(), fixed = 6, complete = fixed + 2 * sums,
                      modes = 2 * numerics::Spectra(w.scene.grid, w.run.components).values.size();
    require(values.size() == complete || values.size() > complete + modes, {},
            "the checkpoint contains {} numbers of the step bias; expected {}, or more than {}; use the other "
            "checkpoint",
            values.size(), complete, complete + modes);
    w.begin = static_cast<std::int64_t>(values[0]);
    w.length = static_cast<std::int64_t>(values[1]);
    w.effort.spent = values[2];
    w.completed = static_cast<std::int64_t>(values[3]);
    w.completed_length = static_cast<std::int64_t>(values[4]);
    w.next = static_cast<std::int64_t>(values[5]);
    const auto from = [&](std::size_t first) { return values.begin() + static_cast<std::ptrdiff_t>(first); };
    std::copy(from(fixed), from(fixed + sums), w.early.begin());
    std::copy(from(fixed + sums), from(complete), w.late.begin());
    if (values.size() == complete) return;
    w.twin_state = numerics::Spectra(w.scene.grid, w.run.components);
    take_numbers(values.subspan(complete), w.twin_state);
    w.twin = w.run.make_twin();
    w.twin->restore(values.subspan(complete + modes));
}

numerics::StepControl control_of_twin(const io::TimeControl& time) {
    return {.method = time.stepper, .dt = 0.5 * time.dt, .tolerance = 0.0, .watches_error = false};
}

double effort_of_estimates(const io::Scene& scene) {
    return scene.accuracy.effort > 0.0 ? scene.accuracy.effort : io::Accuracy{}.effort;
}

double effort_of_step_error(const io::Scene& scene) {
    // Of a chosen step more: a false alarm costs a run.
    const double times = scene.time.chosen == "fields" ? 5.0 : 1.0;
    return times * shares_of_effort(scene).step_error * effort_of_estimates(scene);
}

std::string why_no_step_bias(const io::Scene& scene) {
    if (scene.accuracy.effort == 0.0) return "not measured (accuracy.effort = 0)";
    if (!scene.accuracy.biases) return "not measured";
    const bool noisy = io::has_noise(scene);
    if (noisy && scene.time.tolerance > 0.0) return "not measured (noise and a tolerance)";
    if (!noisy && scene.time.max_error == 0.0) return "not measured (time.max_error = 0)";
    return "";
}

}  // namespace drover::run
