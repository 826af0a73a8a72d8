// measure/statistics.cpp: autocorrelation time, warm-up, and the jackknife over blocks.
#include "drover/measure/statistics.hpp"

#include <gsl/gsl_fft_halfcomplex.h>
#include <gsl/gsl_fft_real.h>

#include <array>
#include <cmath>
#include <utility>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "drover/base/error.hpp"

namespace drover::measure {

namespace {
using Series = std::vector<std::span<const double>>;
using Function = std::function<double(std::span<const double> means)>;

constexpr double window_per_time = 5.0;
constexpr std::size_t samples_per_batch = 5;
constexpr std::size_t lags_at_once = 16;      // as many sums as fit in registers
constexpr std::size_t max_direct_lags = 512;  // beyond, a Fourier transform of the series takes less time
constexpr const char* not_finite =
    "no error estimate: the quantity is not finite for these means; expected nonzero means: check the series from "
    "which "
    "it is computed";

bool all_finite(std::span<const double> values) {
    return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

bool is_constant(std::span<const double> values) {
    if (values.empty()) return true;
    const auto [min, max] = std::ranges::minmax_element(values);
    return *max - *min <= rounding_spread * std::max(std::abs(*min), std::abs(*max));
}

/// Relative to the first value, so that the mean of a constant series is exactly that constant.
double mean_of(std::span<const double> values) {
    double sum = 0.0;
    for (const double value : values) sum += value - values[0];
    return values[0] + sum / static_cast<double>(values.size());
}

/// Sums over i of d_i d_(i+k), d the deviations from the mean, for the lags k = 0 .. n/2: by Fourier transform.
std::vector<double> all_lagged_products(std::span<const double> deviations) {
    const std::size_t n = deviations.size();
    std::size_t length = 2;
    while (length < n + n / 2 + 1) length *= 2;  // zero padding: no lag up to n/2 wraps around
    std::vector<double> work(deviations.begin(), deviations.end());
    work.resize(length);
    gsl_fft_real_radix2_transform(work.data(), 1, length);
    // Real parts 0 to length/2, then the imaginary ones backwards; the power spectrum has none.
    for (std::size_t k = 0; k <= length / 2; ++k) {
        const double imaginary = k % (length / 2) == 0 ? 0.0 : std::exchange(work[length - k], 0.0);
        work[k] = work[k] * work[k] + imaginary * imaginary;
    }
    gsl_fft_halfcomplex_radix2_inverse(work.data(), 1, length);
    work.resize(n / 2 + 1);
    return work;
}

/// Extends `products` beyond the first lags: a few lags per call, then all at once.
void extend_lagged_products(std::span<const double> deviations, std::vector<double>& products) {
    const std::size_t n = deviations.size(), first = products.size(), lags = n / 2 + 1;
    if (first >= max_direct_lags) {
        products = all_lagged_products(deviations);
        return;
    }
    std::array<double, lags_at_once> sums{};
    const std::size_t full = n - std::min(n, first + lags_at_once);
    for (std::size_t i = 0; i < full; ++i)
        for (std::size_t k = 0; k < lags_at_once; ++k) sums[k] += deviations[i] * deviations[i + first + k];
    for (std::size_t i = full; i < n; ++i)
        for (std::size_t k = 0; i + first + k < n && k < lags_at_once; ++k)
            sums[k] += deviations[i] * deviations[i + first + k];
    for (std::size_t k = 0; k < lags_at_once && products.size() < lags; ++k) products.push_back(sums[k]);
}

/// Why there is no error estimate, if there is none.  n: samples after warm-up; tau: in samples.
std::optional<std::string> too_short(std::size_t n, double tau, const Samples& timing, double warm_up) {
    const auto run_for = [&](double samples) {
        return time_text(warm_up + samples * timing.spacing, timing.time_unit, true);
    };
    const double min_times = autocorrelation_times_per_block * static_cast<double>(min_blocks);
    const auto min_samples = static_cast<std::size_t>(std::ceil(min_times / 2.0));
    if (n < min_samples)
        return text("no error estimate: {} after warm-up; at least {} are needed: run for {}",
                    n == 1 ? std::string("one sample") : text("{} samples", n), min_samples,
                    run_for(static_cast<double>(min_samples)));
    const double times = static_cast<double>(n) / tau;
    if (times < min_times)
        return text(
            "no error estimate: the run has {:.3g} autocorrelation times ({}) after warm-up; expected blocks of "
            "{} each, at least {} of them: run for {}",
            times, time_text(static_cast<double>(n) * timing.spacing, timing.time_unit),
            autocorrelation_times_per_block, min_blocks, run_for(min_times * tau));
    return std::nullopt;
}

std::vector<double> means_of(const Series& series) {
    return mapped(series, [](std::span<const double> values) { return mean_of(values); });
}

/// The function of the means with each of the blocks left out in turn.  Series of blocks * length samples.
std::vector<double> leave_one_out(const Series& series, std::size_t blocks, const Function& function) {
    const std::size_t length = series[0].size() / blocks;
    const std::vector<double> means = means_of(series);
    std::vector<double> results, rest(series.size());
    for (std::size_t b = 0; b < blocks; ++b) {
        for (std::size_t s = 0; s < series.size(); ++s) {
            const double block = mean_of(series[s].subspan(b * length, length));
            rest[s] = means[s] + (means[s] - block) / static_cast<double>(blocks - 1);
        }
        results.push_back(function(rest));
    }
    return results;
}

/// Autocorrelation time of blocks: half a block, unless neighbours are correlated by 2.5 standard errors, as where a
/// slow change hides below a fast one, whose time the length of the blocks follows.  Of independent blocks 6 of 1000.
double blocks_per_time(std::span<const double> estimates) {
    const auto count = static_cast<double>(estimates.size());
    const double mean = mean_of(estimates);
    double products = 0.0, squares = 0.0;
    for (std::size_t b = 0; b < estimates.size(); ++b) {
        squares += (estimates[b] - mean) * (estimates[b] - mean);
        if (b > 0) products += (estimates[b] - mean) * (estimates[b - 1] - mean);
    }
    const bool is_correlated = products / squares + 1.0 / count > 2.5 / std::sqrt(count);  // false for 0/0
    return is_correlated ? std::max(0.5, correlation_times(estimates).integrated) : 0.5;
}

/// Sets mean and error from blocks.  Samples at the start that do not fill a block are left out.
void add_jackknife(Series series, const CorrelationTimes& correlation, double spacing, const Function& function,
                   Estimate& result) {
    const auto affordable =
        static_cast<std::size_t>(static_cast<double>(series[0].size()) / autocorrelation_times_per_block /
                                 std::max(correlation.integrated, correlation.coherence));
    const std::size_t blocks = std::clamp(affordable, min_blocks, max_blocks);
    const std::size_t length = series[0].size() / blocks, spare = series[0].size() % blocks;
    for (auto& values : series) values = values.subspan(spare);
    const auto count = static_cast<double>(blocks);

    const double full = function(means_of(series));
    const std::vector<double> estimates = leave_one_out(series, blocks, function);
    if (!std::isfinite(full) || !all_finite(estimates)) {
        result.why_no_error = not_finite;
        return;
    }
    const double mean_estimate = mean_of(estimates);
    double sum = 0.0;
    for (const double value : estimates) sum += (value - mean_estimate) * (value - mean_estimate);
    // Exact for exponential correlations: length * variance of a block mean = 2 tau variance (1 - lost).
    const double tau = correlation.integrated, lost = (tau - 0.25 / tau) / static_cast<double>(length);
    result.mean = full - (count - 1.0) * (mean_estimate - full);
    const double together = 2.0 * blocks_per_time(estimates);  // blocks that are worth one
    result.error = std::sqrt((count - 1.0) / count * sum / (1.0 - lost) * together);
    result.samples = blocks * length;
    result.warm_up += static_cast<double>(spare) * spacing;
    result.blocks = std::max<std::size_t>(2, static_cast<std::size_t>(count / together));
}

/// Reports which samples are not finite.
std::string undefined_samples(std::span<const double> values, std::size_t skipped) {
    const auto is_bad = [](double value) { return !std::isfinite(value); };
    const auto bad = std::ranges::count_if(values, is_bad);
    if (static_cast<std::size_t>(bad) == values.size()) return "no mean: the value is undefined (NaN) in every sample";
    const auto first = std::ranges::find_if(values, is_bad);
    return text(
        "no mean: the value is not finite in {} of {} samples after warm-up; the first is sample {}, {}: choose a "
        "longer warm-up, or see the formula for when it is undefined",
        bad, values.size(), static_cast<std::size_t>(first - values.begin()) + skipped + 1,
        std::isnan(*first) ? "NaN" : text("{}", *first));
}

/// Common to all estimates.  The series include the warm-up.
Estimate estimate(Series series, const Samples& timing, const Function& function) {
    const double spacing = timing.spacing;
    require(!series.empty(), {}, "no series to average; expected at least one");
    require(spacing > 0.0 && std::isfinite(spacing), {}, "samples {} s apart; expected a positive time", spacing);
    for (const auto& values : series)
        require(values.size() == series[0].size(), {}, "series of {} and of {} samples; expected the same length",
                series[0].size(), values.size());
    const std::size_t skipped = std::min(timing.skip, series[0].size());
    Estimate result{.mean = nan,
                    .autocorrelation_time = nan,
                    .warm_up = static_cast<double>(skipped) * spacing,
                    .samples = series[0].size() - skipped};
    CorrelationTimes slowest;
    bool constant = true;
    for (auto& values : series) {
        values = values.subspan(skipped);
        if (!all_finite(values)) {
            result.why_no_error = undefined_samples(values, skipped);
            return result;
        }
        const CorrelationTimes times = correlation_times(values);
        slowest = {std::max(slowest.integrated, times.integrated), std::max(slowest.coherence, times.coherence)};
        constant = constant && is_constant(values);
    }
    result.autocorrelation_time = slowest.integrated * spacing;
    if (result.samples > 0) result.mean = function(means_of(series));
    if (result.samples > 0 && !std::isfinite(result.mean)) result.why_no_error = not_finite;
    else if (result.samples > 1 && constant) result.error = 0.0;
    else if (const auto why = too_short(result.samples, slowest.integrated, timing, result.warm_up))
        result.why_no_error = *why;
    else add_jackknife(std::move(series), slowest, spacing, function, result);
    return result;
}

/// Functions of the values of one series, as several series.
Samples derived(const Samples& samples, std::size_t series,
                const std::vector<std::function<double(double)>>& functions) {
    Samples result{.spacing = samples.spacing, .skip = samples.skip, .time_unit = samples.time_unit};
    for (const auto& function : functions) {
        result.series.push_back(samples.series.at(series));
        for (double& value : result.series.back()) value = function(value);
    }
    return result;
}

std::vector<double> batch_means(std::span<const double> values) {
    std::vector<double> batches;
    for (std::size_t k = 0; k < values.size() / samples_per_batch; ++k)
        batches.push_back(mean_of(values.subspan(k * samples_per_batch, samples_per_batch)));
    return batches;
}

/// The cut of these batches, up to half of them, that minimises the estimated error of the rest.
std::size_t best_cut(std::span<const double> batches) {
    std::size_t best = 0;
    double best_score = infinite;
    double mean = 0.0, squares = 0.0, count = 0.0;  // of the batches from `cut`
    for (std::size_t cut = batches.size(); cut-- > 0;) {
        count += 1.0;
        const double step = batches[cut] - mean;
        mean += step / count;
        squares += step * (batches[cut] - mean);
        const double score = squares / (count * count);
        if (2 * cut <= batches.size() && score <= best_score) {
            best_score = score;
            best = cut;
        }
    }
    return best;
}

/// For each number of batches before the rest, whether their mean is that of the rest within so many standard errors.
std::vector<bool> agreeing(std::span<const double> values, std::size_t rest, double time, double errors) {
    const std::vector<double> batches = batch_means(values.first(rest));
    const std::span<const double> after = values.subspan(rest);
    const double mean = mean_of(after), samples = static_cast<double>(after.size());
    double square = 0.0, sum = 0.0;
    for (const double value : after) square += (value - mean) * (value - mean) / samples;
    std::vector<bool> agrees;
    for (std::size_t number = 1; number <= batches.size(); ++number) {
        sum += batches[batches.size() - number];
        const double count = static_cast<double>(number),
                     error = std::sqrt(2.0 * time * square * (1.0 / (count * samples_per_batch) + 1.0 / samples));
        agrees.push_back(std::abs(sum / count - mean) <= errors * error);
    }
    return agrees;
}
}  // namespace

std::string time_text(double time, const std::string& unit, bool up) {
    const std::string after = unit == "1" ? "" : " " + unit;
    if (!(time > 0.0)) return text("{}{}", time, after);
    const double step = std::pow(10.0, std::floor(std::log10(time)) - 2.0);
    const double steps = up ? std::ceil(time / step - 1e-6) : std::round(time / step);
    return text("{:.6g}{}", step < 1.0 ? steps / std::round(1.0 / step) : steps * std::round(step), after);
}

CorrelationTimes correlation_times(std::span<const double> values) {
    if (!all_finite(values)) return {nan, nan};
    if (values.size() < 2 || is_constant(values)) return {};
    std::vector<double> deviations(values.begin(), values.end()), products;
    const double mean = mean_of(values);
    for (double& value : deviations) value -= mean;
    extend_lagged_products(deviations, products);
    const auto n = static_cast<double>(values.size());
    CorrelationTimes times;
    double sum = 0.5;
    std::size_t window = 0;
    const auto reaches = [&](double time) {
        return window >= values.size() / 2 || static_cast<double>(window) >= window_per_time * time;
    };
    bool summed = false;
    while (!reaches(std::max(sum, times.coherence))) {
        ++window;
        if (window == products.size()) extend_lagged_products(deviations, products);
        const double correlation = products[window] / products[0] * n / (n - static_cast<double>(window));
        sum += correlation;
        times.coherence += 2.0 * correlation * correlation;
        // Of both sums the longer one: an oscillation may end the first window before a slow decay shows.
        const bool ends = reaches(std::max(sum, times.coherence));
        if (ends || (!summed && reaches(sum))) {
            times.integrated = std::max(times.integrated, sum * (1.0 + (2.0 * static_cast<double>(window) + 1.0) / n));
            summed = true;
        }
    }
    return times;
}

std::size_t warm_up_length(std::span<const double> values) {
    if (values.size() / samples_per_batch < 4 || !all_finite(values) || is_constant(values)) return 0;
    const std::vector<double> batches = batch_means(values);
    const std::size_t best = best_cut(batches), length = best * samples_per_batch;
    if (2 * best + 1 >= batches.size()) return length;  // it may not have ended
    // The best cut of a stationary series comes after large values, and what is left of skewed ones has a smaller mean.
    // So what is before it is left out only where it differs: an oscillation that decays does so by its squares.
    const std::span<const double> rest = values.subspan(length);
    const double mean = mean_of(rest), time = autocorrelation_time(rest);
    const auto squares = mapped(values, [&](double value) { return (value - mean) * (value - mean); });
    constexpr double errors_of_mean = 4.0, errors_of_squares = 6.0;  // of which few values decide
    const std::vector<bool> by_mean = agreeing(values, length, time, errors_of_mean),
                            by_squares = agreeing(squares, length, time, errors_of_squares);
    std::size_t kept = best;
    while (kept > 0 && !(by_mean[kept - 1] && by_squares[kept - 1])) --kept;
    return length - kept * samples_per_batch;
}

Estimate estimate_mean(const Samples& samples, std::size_t series) {
    return estimate({samples.series.at(series)}, samples, [](auto means) { return means[0]; });
}

Estimate estimate_function(const Samples& samples, const Function& function) {
    return estimate(Series(samples.series.begin(), samples.series.end()), samples, function);
}

Estimate estimate_susceptibility(const Samples& samples, std::size_t series, double area) {
    // Relative to a value of the series: the variance is the same and keeps its digits where it is small.
    const auto& values = samples.series.at(series);
    const double origin = values.empty() ? 0.0 : values.back();
    const Samples moments =
        derived(samples, series,
                {[=](double p) { return p - origin; }, [=](double p) { return (p - origin) * (p - origin); }});
    return estimate_function(moments, [=](auto means) { return area * (means[1] - means[0] * means[0]); });
}

Estimate estimate_binder_cumulant(const Samples& samples, std::size_t series) {
    const Samples moments =
        derived(samples, series, {[](double p) { return p * p; }, [](double p) { return p * p * p * p; }});
    return estimate_function(moments, [](auto means) { return 1.0 - means[1] / (3.0 * means[0] * means[0]); });
}

Estimate estimate_deviation(const Samples& samples, std::size_t series) {
    return estimate({samples.series.at(series)}, samples, [](auto means) { return std::sqrt(means[0]); });
}

Estimate estimate_local_exponent(const Samples& samples, std::size_t small, std::size_t large, double ratio) {
    require(ratio > 0.0 && ratio != 1.0 && std::isfinite(ratio), {}, "boxes of a ratio of {}; expected one above 1",
            ratio);
    return estimate({samples.series.at(small), samples.series.at(large)}, samples,
                    [=](auto means) { return 0.5 * std::log(means[1] / means[0]) / std::log(ratio); });
}

RoughMean rough_mean(std::span<const double> values, std::size_t skip) {
    const std::span<const double> used = values.subspan(std::min(skip, values.size()));
    const Estimate estimate = estimate_mean({.series = {std::vector<double>(used.begin(), used.end())}}, 0);
    double squares = 0.0;
    for (const double value : used) squares += (value - estimate.mean) * (value - estimate.mean);
    const auto error_of = [&](double times) {
        return estimate.error.value_or(std::sqrt(times * squares) / static_cast<double>(used.size()));
    };
    return {estimate.mean, error_of(std::max(4.0, 2.0 * estimate.autocorrelation_time)), error_of(4.0)};
}

RoughMean paired_difference(std::span<const double> a, std::span<const double> b, std::size_t skip) {
    require(a.size() == b.size(), {}, "a paired difference of {} and {} samples; expected equal numbers", a.size(),
            b.size());
    std::vector<double> values;
    for (std::size_t i = 0; i < a.size(); ++i) values.push_back(a[i] - b[i]);
    return rough_mean(values, skip);
}

}  // namespace drover::measure
