// measure/replicates.cpp: Student's t of the scatter of runs, and a test of their own errors by it.
#include "measure/replicates.hpp"

#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/constants.hpp"
#include "drover/base/error.hpp"

namespace drover::measure {

namespace {

/// Their ratio to the scatter is F where all runs have the same true error: means do not depend on errors.
void add_own_errors(std::span<const Estimate> runs, Replicates& result) {
    const double count = static_cast<double>(runs.size());
    double squares = 0.0, freedom = 0.0;
    for (const Estimate& run : runs) {
        if (!run.error) return;
        squares += *run.error * *run.error;
        // An error that is not from blocks counts as known.
        freedom += run.blocks > 1 ? static_cast<double>(run.blocks) - 1.0 : 1e6;
    }
    result.own_error = std::sqrt(squares) / count;
    if (!(squares > 0.0) || runs.size() < 2) return;
    result.chi_squared = result.deviation * result.deviation / (squares / count);
    const double above = gsl_cdf_fdist_Q(result.chi_squared, count - 1.0, freedom);
    result.chance = std::min(above, 1.0 - above);
}
constexpr double turn = 2.0 * std::numbers::pi;

/// The sum of the unit vectors of directions.
std::complex<double> resultant(std::span<const Estimate> runs) {
    std::complex<double> sum;
    for (const Estimate& run : runs) sum += std::polar(1.0, run.mean);
    return sum;
}

/// Angles within half a turn of the direction of all.
std::vector<Estimate> unwrapped(std::span<const Estimate> runs) {
    std::vector<Estimate> result(runs.begin(), runs.end());
    const double middle = std::arg(resultant(runs));
    for (Estimate& run : result) run.mean = middle + std::remainder(run.mean - middle, turn);
    return result;
}

Replicates combined(std::span<const Estimate> runs) {
    const double count = static_cast<double>(runs.size());
    Replicates result{.deviation = nan, .chi_squared = nan, .chance = nan};
    Estimate& mean = result.mean;
    for (const Estimate& run : runs) {
        mean.mean += run.mean / count;
        mean.autocorrelation_time += run.autocorrelation_time / count;
        mean.warm_up = std::max(mean.warm_up, run.warm_up);
        mean.samples += run.samples;
        if (!run.why_no_error.empty()) mean.why_no_error = run.why_no_error;
        if (!run.error && run.averaging != Averaging::maximum) ++result.without_error;
    }
    mean.blocks = runs.size();
    if (!std::isfinite(mean.mean)) return result;
    if (runs.size() == 1) {
        mean.error = runs[0].error;
        add_own_errors(runs, result);
        return result;
    }
    double squares = 0.0;
    for (const Estimate& run : runs) squares += (run.mean - mean.mean) * (run.mean - mean.mean);
    result.deviation = std::sqrt(squares / (count - 1.0));
    // Half of the interval of Student's t that covers as much as one standard deviation of a normal distribution.
    constexpr double one_sigma = 0.841344746068542949;  // of a normal distribution, below mean + sigma
    mean.error = gsl_cdf_tdist_Pinv(one_sigma, count - 1.0) * result.deviation / std::sqrt(count);
    add_own_errors(runs, result);
    // Of all pairs a tenth differ by less than an eighth of the error of their difference.
    constexpr std::size_t few = 8;
    if (runs.size() < few) mean.error = std::max(*mean.error, result.own_error.value_or(0.0));
    mean.why_no_error.clear();
    return result;
}
}  // namespace

Replicates combine(std::span<const Estimate> runs) {
    require(!runs.empty(), {}, "no runs to combine; expected at least one");
    if (runs.front().averaging != Averaging::direction) return combined(runs);
    Replicates result = combined(unwrapped(runs));
    result.mean.mean = std::remainder(result.mean.mean, turn);
    result.mean.averaging = Averaging::direction;
    constexpr double by_chance = 3.0, common = 0.9;  // n R^2 of random directions is larger in one of twenty cases
    const auto count = static_cast<double>(runs.size());
    if (const double sum = std::abs(resultant(runs)); sum * sum < by_chance * count && sum < common * count) {
        result.mean.error.reset();
        result.mean.why_no_error = "no error estimate: the runs have no common direction";
    }
    return result;
}

bool contradicts(const Replicates& replicates) {
    constexpr double rare = 5e-4;
    return replicates.chance < rare;  // false for NaN
}

}  // namespace drover::measure
