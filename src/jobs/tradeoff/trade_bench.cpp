// jobs/tradeoff/trade_bench.cpp: trials of one scene within a budget.
#include "jobs/tradeoff/trade_bench.hpp"

#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "files/archive_reader.hpp"
#include "io/scene.hpp"
#include "measure/replicates.hpp"
#include "run/run_scene.hpp"
#include "run/simulation_type.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::jobs {

double size_of(const io::Scene& scene) {
    return io::has_grid(scene.kind) ? static_cast<double>(numerics::points(scene.grid))
                                    : scene.particles.cell.lx * scene.particles.cell.ly;
}

double unit_of_time(const io::Scene& scene) {
    return scene.kind == io::SceneKind::particles && scene.output.frame_every > 0.0 ? scene.output.frame_every
                                                                                    : scene.output.sample_every;
}

Bias less(const Bias& a, const Bias& b) { return {a.value - b.value, std::hypot(a.error, b.error)}; }

std::string time_text(const BenchFacts& facts, double time) {
    return io::in_unit("{:.6g}", time, "s", facts.unit_names);
}

std::string text_of(const LevelOutcome& outcome) {
    constexpr std::array patterns{
        "",
        "bias not measured",
        "{}",
        "the error of its steps is {} of a field's fluctuation: with another noise path it may fail",
        "it has no {}",
        "not possible: {}",
        "not run: the budget is spent",
        "not run yet",
        "not considered: the given grid is part of the model"};  // in the order of LevelState
    return text(patterns[static_cast<std::size_t>(outcome.state)], outcome.detail);
}

void reject_wrong_steps(std::vector<std::vector<TrialMeasurement>>& runs) {
    constexpr double too_wrong = 0.5;
    double min_error = INFINITY;
    for (const std::vector<TrialMeasurement>& ladder : runs)
        for (const TrialMeasurement& run : ladder)
            if (run.is_measured()) min_error = std::min(min_error, run.step_error);
    if (min_error > 0.5 * too_wrong) return;
    for (std::vector<TrialMeasurement>& ladder : runs)
        for (TrialMeasurement& run : ladder)
            if (run.is_measured() && run.step_error > too_wrong)
                run.outcome = {LevelState::wrong_steps, text("{:.2g}", run.step_error)};
}

namespace {
/// Root mean square deviation of the samples from `from` on, of a series or of its difference from another.
double deviation(const std::vector<double>& values, std::size_t from, const std::vector<double>* less = nullptr) {
    const auto count = static_cast<double>(values.size() - from);
    const auto value = [&](std::size_t i) { return values[i] - (less == nullptr ? 0.0 : (*less)[i]); };
    double mean = 0.0, squares = 0.0;
    for (std::size_t i = from; i < values.size(); ++i) mean += value(i) / count;
    for (std::size_t i = from; i < values.size(); ++i) squares += std::pow(value(i) - mean, 2) / count;
    return std::sqrt(squares);
}

double largest_step_error(const files::ArchiveReader& archive) {
    double largest = 0.0;  // of those that are resolved: only fields that have parted are asked for
    for (const double value : run::series_of(archive, "step_error")) largest = std::fmax(largest, value);
    return largest;
}

/// The samples at whole multiples of a longer spacing; none where it is not a multiple.
std::vector<double> common_samples(const TargetNumber& number, double spacing) {
    const double times = std::round(spacing / number.spacing);
    if (std::abs(times * number.spacing / spacing - 1.0) > 1e-9) return {};
    std::vector<double> result;
    for (std::size_t i = 0; i < number.series.size(); i += static_cast<std::size_t>(times))
        result.push_back(number.series[i]);
    return result;
}
}  // namespace

TradeBench::TradeBench(const io::Scene& given, const std::string& of, const TargetOptions& options)
    : trials(of, options),
      scene(given),
      budget(options.budget),
      is_collecting(options.collect),
      targets_(options.targets) {
    unit_names = given.units;
}

TrialRun TradeBench::trial_of(const std::vector<std::string>& overrides, bool rounds_up) const {
    io::Scene timed = scene;
    timed.time.end = duration;
    return {io::changed(timed, overrides), rounds_up};
}

void TradeBench::set_rate(const TrialMeasurement& base) {
    rate_ = (base.step_seconds * duration + base.start_seconds) / (size_of(scene) * duration / scene.time.dt);
}

double TradeBench::expected_seconds(const TrialRun& trial) const {
    if (rate_ == 0.0) return 0.0;
    return rate_ * size_of(trial.scene) * trial.scene.time.end / trial.scene.time.dt;
}

bool TradeBench::run(std::vector<TrialRun> wanted) {
    std::ranges::stable_sort(wanted, [&](const TrialRun& a, const TrialRun& b) {
        return expected_seconds(a) < expected_seconds(b);
    });
    std::vector<TrialRun> affordable;
    double cost = spent;
    for (const TrialRun& trial : wanted) {
        if (trials.find(trial) == nullptr) cost += expected_seconds(trial);
        if (cost <= budget) affordable.push_back(trial);
    }
    if (affordable.size() < wanted.size()) is_short = true;
    const bool completed = trials.run(affordable);
    for (const TrialRun& trial : affordable) {
        const TrialResult* result = trials.find(trial);
        if (result == nullptr) continue;
        double& counted = counted_[result->archive.string()];
        hosts.insert(result->host);
        programs.insert(result->program);
        spent += result->seconds() - counted;
        counted = result->seconds();
    }
    return completed;
}

/// Per second of the scene.  Where a kill has lost most of the times, a few steps are timed, once for all processes.
double TradeBench::step_seconds_of(const TrialRun& trial, const TrialResult& result) {
    constexpr double known = 0.5;  // of the trial
    const double reported = result.step_seconds / std::max(result.timed, 1e-9);
    if (result.timed >= known * result.end) return reported;
    const auto timed = trials.agreed("cost-" + result.archive.stem().string(), [&]() -> std::vector<double> {
        io::Scene alone = trial.scene;
        alone.run.threads = 1;
        const auto expected = run::expected_time(alone);
        return {expected ? expected->total / alone.time.end : reported};
    });
    return timed ? timed->front() : reported;
}

TrialMeasurement TradeBench::measured(const std::vector<std::string>& overrides, bool rounds_up) {
    const TrialRun trial = trial_of(overrides, rounds_up);
    const TrialResult* result = trials.find(trial);
    if (result == nullptr) return {.outcome = {is_collecting ? LevelState::not_ended : LevelState::not_affordable}};
    if (result->failure) return {.outcome = {LevelState::failed, *result->failure}};
    const auto key = std::pair(result->archive.string(), result->end);
    if (const auto known = measured_.find(key); known != measured_.end()) return known->second;
    trials.require_archive(trial, *result);
    const files::ArchiveReader archive(result->archive);
    const run::Report report = run::make_report(archive);
    TrialMeasurement measured{.start_seconds = result->start_seconds,
                              .step_seconds = step_seconds_of(trial, *result),
                              .end = result->end,
                              .step_error = largest_step_error(archive)};
    for (const AccuracyTarget& target : targets_) {
        try {
            measured.numbers.push_back(target_number(target, report, archive));
        } catch (const Error& error) {
            if (overrides.empty() || !is_of_scene(error.fault())) throw;  // a simpler model may lack what is wanted
            return measured_[key] = {.outcome = {LevelState::lacks_number, target.text}, .numbers = {}};
        }
    }
    if (warm_up == 0.0 && overrides.empty())
        warm_up = static_cast<double>(report.summary.warm_up) * scene.output.sample_every;
    return measured_[key] = measured;
}

std::size_t TradeBench::skip(const TargetNumber& number) const {
    return std::min(number.series.size(), static_cast<std::size_t>(std::ceil(warm_up / number.spacing - 1e-9)));
}

Bias TradeBench::mean_of(const TargetNumber& number) const {
    const double error = number.error.value_or(0.0);
    const Bias mean =
        number.series.empty() ? Bias{number.mean, error, error} : measure::rough_mean(number.series, skip(number));
    return statistical ? mean : Bias{mean.value};
}

std::vector<Fluctuation> TradeBench::fluctuations(const TrialMeasurement& run) const {
    // The run finds its own tau, over 80 m of it with a relative error of sqrt(20/(80 m)): below m with 95 % for 1.75.
    constexpr double own = 1.75, max_margin = 2.5;
    std::vector<Fluctuation> result;
    for (std::size_t w = 0; w < run.numbers.size(); ++w) {
        const TargetNumber& number = run.numbers[w];
        const std::span<const double> used = std::span<const double>(number.series).subspan(skip(number));
        const double tau = measure::autocorrelation_time(used), window = 5.0 * tau;
        // Its relative standard error, see autocorrelation_time.
        const double error =
            std::sqrt(2.0 * (2.0 * window + 1.0) / static_cast<double>(std::max<std::size_t>(used.size(), 1)));
        result.push_back({std::max(mean_of(number).error, min_error_.empty() ? 0.0 : min_error_[w]),
                          tau * number.spacing, std::min(max_margin, own * (1.0 + error))});
    }
    return result;
}

bool TradeBench::may_be_longer(const TrialMeasurement& base) const {
    constexpr double enough_blocks = 16.0, trials_of_study = 20.0;
    TrialRun longer = trial_of({});
    longer.scene.time.end = 2.0 * duration;
    if (!statistical || trials_of_study * 2.0 * duration * base.step_seconds > budget ||
        (is_collecting && trials.find(longer) == nullptr))
        return false;
    return std::ranges::any_of(fluctuations(base), [&](const Fluctuation& one) {
        return duration - warm_up < enough_blocks * measure::autocorrelation_times_per_block * one.time;
    });
}

std::vector<std::string> TradeBench::drift_notes(const TrialMeasurement& run) const {
    constexpr double clear = 3.0;  // standard errors
    std::vector<std::string> notes;
    for (std::size_t w = 0; statistical && w < targets_.size(); ++w) {
        const std::span<const double> series(run.numbers[w].series), used = series.subspan(skip(run.numbers[w]));
        const std::size_t half = used.size() / 2;
        if (half < measure::min_blocks) continue;
        const auto mean_in = [](std::span<const double> part) {
            const measure::RoughMean mean = measure::rough_mean(part, 0);
            return Bias{mean.value, mean.least_error};
        };
        const Bias drift = less(mean_in(used.last(half)), mean_in(used.first(half)));
        if (std::abs(drift.value) <= std::max(clear * drift.error, allowed[w])) continue;
        notes.push_back(
            drift_note(w, text("over the second half of the trials of {} is {:.3g} +- {:.1g} {} than over the first",
                               time_text(*this, duration), std::abs(drift.value), drift.error,
                               drift.value > 0.0 ? "larger" : "smaller")));
    }
    return notes;
}

std::string TradeBench::drift_note(std::size_t target, const std::string& what) const {
    return text(
        "{} drifts: its mean {}, more than the {:.2g} allowed: errors and durations given here hold only once it "
        "has settled; give a larger --budget or analysis.warm_up",
        targets_[target].text, what, allowed[target]);
}

std::vector<std::vector<std::string>> TradeBench::reseeded(const std::vector<std::string>& overrides) const {
    std::vector<std::vector<std::string>> all;
    const int count = statistical ? 3 : 0;
    for (int k = 1; k <= count; ++k) {
        all.push_back(overrides);
        all.back().push_back(text("run.seed={}", scene.run.seed + k));
    }
    return all;
}

std::vector<std::string> TradeBench::widen(const std::vector<std::string>& overrides) {
    std::vector<TrialMeasurement> runs{measured(overrides)};
    for (const std::vector<std::string>& changes : reseeded(overrides))
        if (TrialMeasurement run = measured(changes); run.is_measured()) runs.push_back(std::move(run));
    min_error_.assign(targets_.size(), 0.0);
    std::vector<std::string> notes;
    for (std::size_t w = 0; runs.size() > 1 && w < targets_.size(); ++w) {
        const measure::Replicates seeds = measure::combine(mapped(runs, [&](const TrialMeasurement& run) {
            const Bias mean = mean_of(run.numbers[w]);
            return measure::Estimate{.mean = mean.value, .error = mean.error};
        }));
        const bool is_doubted = seeds.own_error == 0.0 || (measure::contradicts(seeds) && seeds.chi_squared > 1.0);
        if (!is_doubted) continue;
        // Twice this holds the truth with the probability of two standard errors, although few runs tell it.
        constexpr double two_sigma = 0.977249868051821;  // of a normal distribution, below mean + 2 sigma
        const auto freedom = static_cast<double>(runs.size() - 1);
        min_error_[w] = seeds.deviation * gsl_cdf_tdist_Pinv(two_sigma, freedom) / 2.0;
        notes.push_back(text(
            "{} differs by {:.2g} between trials of {} with {} seeds, although each trial estimates an error of "
            "{:.2g}: it fluctuates more slowly than the trials show, or has several states; the statistical error is "
            "taken from the seeds: give a larger --budget",
            targets_[w].text, seeds.deviation, time_text(*this, duration), runs.size(),
            seeds.own_error.value_or(0.0) * std::sqrt(static_cast<double>(runs.size()))));
    }
    return notes;
}

double TradeBench::sparse_sampling(const TrialMeasurement& base) const {
    constexpr double fewest = 64.0;
    double times = duration / (fewest * scene.output.sample_every);
    for (const TargetNumber& number : base.numbers) {
        const std::span<const double> series(number.series);
        times = std::min(times, measure::autocorrelation_time(series.subspan(skip(number))) / 2.0);
    }
    return scene.output.sample_every * std::exp2(std::floor(std::log2(std::max(times, 1.0))));
}

Bias TradeBench::difference(const TargetNumber& a, const TargetNumber& b) const {
    const Bias apart = less(mean_of(a), mean_of(b));
    if (scene.kind == io::SceneKind::particles || a.series.empty() || b.series.empty()) return apart;
    if (!statistical && a.spacing != b.spacing) return apart;
    const double spacing = std::max(a.spacing, b.spacing);
    const std::vector<double> one = common_samples(a, spacing), other = common_samples(b, spacing);
    if (one.empty() || other.empty()) return apart;
    const std::size_t common = std::min(one.size(), other.size());
    Bias paired = measure::paired_difference(std::span(one).first(common), std::span(other).first(common),
                                             skip(a.spacing > b.spacing ? a : b));
    if (!statistical) paired.error = 0.0;
    return paired.error < apart.error ? paired : apart;
}

std::vector<Bias> TradeBench::differences(const TrialMeasurement& a, const TrialMeasurement& b) const {
    std::vector<Bias> result;
    for (std::size_t w = 0; w < targets_.size(); ++w) result.push_back(difference(a.numbers[w], b.numbers[w]));
    return result;
}

double TradeBench::ratio(const std::vector<Bias>& biases) const {
    double largest = 0.0;
    for (std::size_t w = 0; w < biases.size(); ++w) largest = std::max(largest, std::abs(biases[w].value) / allowed[w]);
    return largest;
}

bool TradeBench::is_resolved(const std::vector<Bias>& biases, double part) const {
    for (std::size_t w = 0; w < biases.size(); ++w)
        if (std::abs(biases[w].value) > std::max(part * allowed[w], 2.0 * biases[w].error)) return false;
    return true;
}

bool TradeBench::are_independent(const TrialMeasurement& a, const TrialMeasurement& b) const {
    constexpr double much = 0.5;   // of the fluctuations
    constexpr double alive = 0.1;  // of the whole series: what has all but died away does not fluctuate
    constexpr std::size_t fewest = 32;
    if (ratio(differences(a, b)) <= 1.0) return false;
    for (std::size_t w = 0; w < targets_.size(); ++w) {
        const std::vector<double>&one = a.numbers[w].series, &other = b.numbers[w].series;
        if (one.size() < fewest || one.size() != other.size()) continue;
        const std::size_t late = other.size() - other.size() / 4;
        const double fluctuation = deviation(other, late);
        if (fluctuation > alive * deviation(other, 0) && deviation(one, late, &other) > much * fluctuation) return true;
    }
    return false;
}

}  // namespace drover::jobs
