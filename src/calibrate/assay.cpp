// calibrate/assay.cpp: seeds of trials, errors over trials, and the rule that says when they are enough.
#include "drover/calibrate/assay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"

namespace drover::calibrate {

namespace {
constexpr std::size_t resamples = 400;
constexpr double max_failing = 0.02;  // of resamples: they lie in the tails, and an error without them is too small

/// Mean of each number over the chosen trials.
std::vector<double> means_of(std::span<const Trial> trials, std::span<const std::size_t> chosen) {
    std::vector<double> means(trials.front().size(), 0.0);
    for (const std::size_t t : chosen)
        for (std::size_t i = 0; i < means.size(); ++i) means[i] += trials[t][i];
    for (double& mean : means) mean /= static_cast<double>(chosen.size());
    return means;
}

/// The spread of one quantity over resamples; and what they lie beside the estimate on average, which it lies beside the truth.
void set_error_and_bias(measure::Estimate& estimate, const std::vector<std::vector<double>>& values,
                        std::size_t quantity) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (const std::vector<double>& value : values)
        if (std::isfinite(value[quantity])) {
            const double apart = value[quantity] - estimate.mean;
            sum += apart, squares += apart * apart, count += 1.0;
        }
    if (!std::isfinite(estimate.mean) || count < (1.0 - max_failing) * static_cast<double>(values.size())) {
        estimate.refusal = text("error refused: {} of {} resamples of the {} trials give no value",
                                static_cast<double>(values.size()) - count, values.size(), estimate.samples);
        return;
    }
    const double trials = static_cast<double>(estimate.samples);
    estimate.error = std::sqrt(std::max(squares - sum * sum / count, 0.0) / (count - 1.0) * trials / (trials - 1.0));
    estimate.mean -= sum / count;
}

void check(const Goal& goal) {
    require(goal.relative_error > 0.0 && std::isfinite(goal.relative_error), {},
            "a relative error of {} is asked; expected a number above 0", goal.relative_error);
    require(goal.round >= 1 && goal.round * goal.min_rounds >= measure::min_blocks, {},
            "{} rounds of {} trials before the first look; expected {} trials or more, or their spread says little",
            goal.min_rounds, goal.round, measure::min_blocks);
    require(goal.max_trials >= goal.round * goal.min_rounds, {},
            "at most {} trials, with {} rounds of {} before the first look; expected at least as many", goal.max_trials,
            goal.min_rounds, goal.round);
}

/// Error beside what is allowed: at most 1 when it is good enough.
double excess(const measure::Estimate& estimate, const Goal& goal) {
    if (!estimate.error || !std::isfinite(estimate.mean)) return std::numeric_limits<double>::infinity();
    if (*estimate.error == 0.0) return 0.0;
    return *estimate.error / (goal.relative_error * std::abs(estimate.mean));
}

/// What the worst of the wanted quantities lacks, as a sentence.
std::string shortfall_of(const Assay& assay, const Measurement& measurement, const Goal& goal) {
    std::size_t worst = assay.quantities.size();
    double most = 1.0;
    for (std::size_t q = 0; q < assay.quantities.size(); ++q)
        if (const double found = excess(measurement.estimates[q], goal); assay.quantities[q].wanted && found > most)
            worst = q, most = found;
    if (worst == assay.quantities.size()) return "";
    const std::string& name = assay.quantities[worst].name;
    const measure::Estimate& estimate = measurement.estimates[worst];
    if (!estimate.error)
        return text("{}: {} is not known after {} trials: {}", assay.name, name, measurement.trials, estimate.refusal);
    const double trials = std::ceil(static_cast<double>(measurement.trials) * most * most);
    if (std::abs(estimate.mean) < 2.0 * *estimate.error)
        return text(
            "{}: {} = {:.3g} +- {:.2g} {} after {} trials cannot be told from 0; an error of {:.3g} % was asked",
            assay.name, name, estimate.mean, *estimate.error, assay.quantities[worst].unit, measurement.trials,
            100.0 * goal.relative_error);
    return text("{}: {} is known to {:.3g} % after {} trials; {:.3g} % was asked: about {:.0f} trials would do",
                assay.name, name, 100.0 * *estimate.error / std::abs(estimate.mean), measurement.trials,
                100.0 * goal.relative_error, trials);
}
}  // namespace

std::uint64_t trial_seed(std::uint64_t seed, const std::string& assay, std::uint64_t trial) {
    std::uint64_t named = 14695981039346656037u;  // FNV-1a
    for (const char letter : assay) named = (named ^ static_cast<unsigned char>(letter)) * 1099511628211u;
    double drawn = 0.0;
    fill_uniform({.seed = seed, .stream = Stream::trial, .step = named}, trial, 1, {&drawn, 1});
    return static_cast<std::uint64_t>(std::ldexp(drawn, 52));  // fits a double: a checkpoint may hold it as one
}

Trial run_trial(const Assay& assay, const SystemFactory& make, const Conditions& conditions, std::uint64_t trial) {
    require(dem::is_periodic(conditions.setup.cell), {}, "{}: a cell of shape \"{}\"; expected \"periodic\"",
            assay.name, conditions.setup.cell.shape);
    return assay.trial(make, conditions.setup, trial_seed(conditions.seed, assay.name, trial));
}

std::vector<measure::Estimate> estimate(const Assay& assay, std::span<const Trial> trials) {
    require(trials.size() >= 2, {}, "{}: {} trials; expected two or more", assay.name, trials.size());
    for (const Trial& trial : trials)
        require(trial.size() == trials.front().size(), {}, "{}: trials of {} and of {} numbers; expected as many",
                assay.name, trials.front().size(), trial.size());
    const Estimator estimator = assay.estimator(trials);
    std::vector<std::size_t> chosen(trials.size());
    for (std::size_t t = 0; t < chosen.size(); ++t) chosen[t] = t;
    std::vector<measure::Estimate> estimates;
    for (const double value : estimator(means_of(trials, chosen)))
        estimates.push_back({.mean = value, .samples = trials.size(), .blocks = trials.size()});
    std::vector<double> drawn(trials.size());
    std::vector<std::vector<double>> values;
    for (std::size_t r = 0; r < resamples; ++r) {
        fill_uniform({.stream = Stream::bootstrap, .step = r}, 0, 1, drawn);
        for (std::size_t t = 0; t < chosen.size(); ++t)
            chosen[t] = static_cast<std::size_t>(drawn[t] * static_cast<double>(trials.size()));
        values.push_back(estimator(means_of(trials, chosen)));
    }
    for (std::size_t q = 0; q < estimates.size(); ++q) set_error_and_bias(estimates[q], values, q);
    return estimates;
}

StoppingDecision judge(const Assay& assay, std::span<const Trial> trials, const Goal& goal) {
    check(goal);
    for (std::size_t count = goal.round * goal.min_rounds;; count += goal.round) {
        if (count > trials.size()) return {.begin = trials.size(), .end = count};
        Measurement found{.estimates = estimate(assay, trials.first(count)), .trials = count};
        found.diagnosis = assay.conclude ? assay.conclude(found.estimates) : "";
        found.unmet_target = shortfall_of(assay, found, goal);
        found.reached = found.unmet_target.empty();
        if (found.reached || count + goal.round > goal.max_trials)
            return {.begin = count, .end = count, .measurement = std::move(found)};
    }
}

Measurement carry_out(const Assay& assay, const SystemFactory& make, const Conditions& conditions, const Goal& goal) {
    std::vector<Trial> trials;
    for (;;) {
        StoppingDecision judgement = judge(assay, trials, goal);
        if (judgement.measurement) return std::move(*judgement.measurement);
        for (std::size_t t = judgement.begin; t < judgement.end; ++t)
            trials.push_back(run_trial(assay, make, conditions, t));
    }
}

}  // namespace drover::calibrate
