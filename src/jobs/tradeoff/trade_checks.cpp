// jobs/tradeoff/trade_checks.cpp: the scene and the duration of the first trials; convergence with the grid, and drift
// beyond that duration.
#include "jobs/tradeoff/trade_front.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"
#include "io/scene.hpp"
#include "jobs/tradeoff/trade_axes.hpp"
#include "run/run_scene.hpp"
#include "run/step_choice.hpp"

namespace drover::jobs {

io::Scene trial_scene(const io::Scene& scene) {
    io::Scene result = run::with_chosen_step(scene, true);
    result.found.step = {};
    if (io::has_grid(scene.kind)) result.output.frame_every = 0.0;
    if (io::has_grid(scene.kind)) result.accuracy.effort = 0.0;  // the trials themselves measure it
    return result;
}

namespace {
/// On the finest grid on which one trial takes at most a fifth of the budget [core seconds]; none where there is none.
std::optional<io::Scene> affordable_scene(const io::Scene& scene, double budget) {
    constexpr double part = 0.2;  // of the budget, for the first trial
    const auto is_affordable = [&](const io::Scene& one) {
        const std::optional<run::ExpectedTime> expected = run::expected_time(one);
        return !expected || expected->total <= part * budget;
    };
    if (is_affordable(scene)) return scene;
    const std::vector<AxisLevel> levels = grid_levels(scene, false);
    for (std::size_t k = levels.size(); k-- > 0;) {
        if (is_given(levels[k])) continue;
        const io::Scene coarser = io::changed(scene, levels[k].overrides);
        if (size_of(coarser) <= size_of(scene) && is_affordable(coarser)) return coarser;
    }
    return std::nullopt;
}

/// Of a run that takes a fortieth of the budget, and makes 64 samples at least [s].
double first_duration(const io::Scene& scene, double budget) {
    constexpr double part = 1.0 / 40.0, min_samples = 64.0;
    const std::optional<run::ExpectedTime> expected = run::expected_time(scene);
    const double affordable =
        expected ? part * budget * scene.time.end / std::max(expected->total, 1e-9) : scene.time.end;
    const double unit = unit_of_time(scene);
    double duration = unit * std::ceil(min_samples * scene.output.sample_every / unit);
    while (2.0 * duration <= std::min(affordable, scene.time.end)) duration *= 2.0;
    return duration;
}
}  // namespace

std::optional<TrialStart> trial_start(TradeBench& bench) {
    const io::Scene& scene = bench.scene;
    const std::string of = text("-{:.17g}", bench.budget);
    TrialStart start{.scene = scene, .duration = scene.time.end};
    if (bench.statistical) {
        const auto found =
            bench.trials.agreed("duration" + of, [&] { return std::vector{first_duration(scene, bench.budget)}; });
        if (!found) return std::nullopt;
        start.duration = found->front();
        return start;
    }
    const auto found = bench.trials.agreed("grid" + of, [&]() -> std::vector<double> {
        const std::optional<io::Scene> one = affordable_scene(scene, bench.budget);
        if (!one) return {};
        return {static_cast<double>(one->grid.nx), static_cast<double>(one->grid.ny)};
    });
    if (!found) return std::nullopt;
    if (found->empty()) {
        const std::optional<run::ExpectedTime> expected = run::expected_time(scene);
        fail_run(
            "a run of the scene takes {} of core time, and so does each trial; the budget of {} is too small: give a "
            "larger --budget",
            duration_text(expected ? expected->total : 0.0), duration_text(bench.budget));
    }
    const auto nx = static_cast<int>((*found)[0]), ny = static_cast<int>((*found)[1]);
    if (nx != scene.grid.nx || ny != scene.grid.ny)
        start.scene = io::changed(scene, {text("grid.nx={}", nx), text("grid.ny={}", ny)});
    return start;
}

void require_relative(const AccuracyTarget& target, const std::string& unit, const Bias& mean) {
    if (!target.is_relative) return;
    const SourceLocation where{.file = "--want " + target.text};
    require(mean.value != 0.0, where,
            "the mean is 0, so an error in per cent is undefined; expected an absolute error, such as "
            "{}=\"0.01 {}\"",
            target.text, unit);
    constexpr double clear = 3.0;  // standard errors
    require(std::abs(mean.value) >= clear * mean.least_error, where,
            "the mean is {:.2g} +- {:.2g} in a trial, which may be 0, so an error in per cent is undefined; "
            "expected an absolute error, such as {}=\"{:.1g} {}\", or a larger --budget",
            mean.value, mean.error, target.text, mean.error, unit);
}

std::vector<std::string> coarser_notes(const io::Scene& scene, const std::string& given, const std::string& tried) {
    std::vector<std::string> notes{
        text("the budget is too small for trials on {}: its grid error is that of {}", given, tried)};
    if (has_random_start(scene))
        notes.push_back(
            text("the random start differs on {}: the values above are those of the trials, and those of the run "
                 "will differ; only the relative errors carry over",
                 tried));
    return notes;
}

Bias bias_of_finest(const Bias& longer, const Bias& last, bool is_noisy) {
    if (!is_noisy) return {last.value / 3.0, last.error / 3.0};
    constexpr double of_white_noise = 0.5, largest = 2.0 / 3.0, clear = 3.0, uncertainty = 0.25;
    double ratio = of_white_noise;
    if (std::abs(longer.value) > clear * longer.error)
        ratio = std::min((std::abs(last.value) + last.error) / std::abs(longer.value), largest);
    const double rest = ratio / (1.0 - ratio);
    return {rest * last.value, rest * std::hypot(last.error, uncertainty * last.value)};
}

bool converges(const GridSteps& steps, const std::vector<double>& allowed) {
    for (std::size_t w = 0; w < steps.last.size(); ++w) {
        const Bias& last = steps.last[w];
        const bool small = std::abs(last.value) < std::max(0.25 * allowed[w], 4.0 * last.error);
        const bool shrinks = std::abs(last.value) < 2.0 / 3.0 * std::abs(steps.longer[w].value);
        if (!small && !shrinks) return false;
    }
    return true;
}

double longer_duration(double trial, double affordable) {
    const double times = std::floor(affordable / trial);
    return times > 1.0 ? times * trial : 0.0;
}

LaterDrift later_drift(TradeBench& bench, const Candidate& best, const std::vector<Bias>& references) {
    constexpr double clear = 3.0;  // standard errors
    LaterDrift found;
    const double before = bench.duration, left = 0.5 * (bench.budget - bench.spent);
    const double duration = longer_duration(before, best.end * std::min(1.0, left / best.seconds));
    if (duration == 0.0) return found;
    std::vector<std::string> overrides = overrides_of(best);
    overrides.push_back(text("run.seed={}", bench.scene.run.seed + 4));  // after those of Study::reseeded
    bench.duration = duration;
    found.stopped = !bench.run({bench.trial_of(overrides)});
    const TrialMeasurement run = bench.measured(overrides);
    bench.duration = before;
    if (found.stopped || !run.is_measured()) return found;
    for (std::size_t w = 0; w < references.size(); ++w) {
        const Bias mean = bench.mean_of(run.numbers[w]), bias = best.parts[w].biases();
        const double moved = mean.value - references[w].value - bias.value,
                     error = std::hypot(mean.error, std::hypot(references[w].error, bias.error));
        if (std::abs(moved) <= std::max(clear * error, bench.allowed[w])) continue;
        found.notes.push_back(bench.drift_note(w, text("over {} is {:.3g} +- {:.1g} {} than over the trials of {}",
                                                       time_text(bench, run.end), std::abs(moved), error,
                                                       moved > 0.0 ? "larger" : "smaller", time_text(bench, before))));
    }
    if (!found.notes.empty() && (1.0 + run.end / before) * bench.spent <= bench.budget) found.affordable = run.end;
    return found;
}

}  // namespace drover::jobs
