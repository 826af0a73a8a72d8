// tests/measure/statistics.cpp: errors of correlated series against the exact statistics of first-order autoregression.
#include "drover/measure/statistics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"

namespace drover::measure::statistics_tests {
namespace {

using testing::HasSubstr;

/// x_i = phi x_(i-1) + sqrt(1 - phi^2) noise, stationary from the start: mean 0, variance 1.
std::vector<double> autoregression(double phi, std::size_t size, std::uint64_t seed) {
    std::vector<double> values(size);
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, values);
    for (std::size_t i = 1; i < size; ++i) values[i] = phi * values[i - 1] + std::sqrt(1.0 - phi * phi) * values[i];
    return values;
}

double exact_time(double phi) { return 0.5 * (1.0 + phi) / (1.0 - phi); }

/// Probability that Student's t of `freedom` degrees lies within +-t: Simpson's rule on its density.
double student_probability(double t, double freedom) {
    const int steps = 1000;
    double sum = 0.0;
    for (int i = 0; i <= steps; ++i) {
        const double x = t * i / steps, weight = i == 0 || i == steps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
        sum += weight * std::pow(1.0 + x * x / freedom, -(freedom + 1.0) / 2.0);
    }
    return 2.0 * sum * t / steps / 3.0 * std::exp(std::lgamma((freedom + 1.0) / 2.0) - std::lgamma(freedom / 2.0)) /
           std::sqrt(freedom * std::numbers::pi);
}

/// The autocorrelation time by the sums that define it.
double time_by_definition(const std::vector<double>& values) {
    const std::size_t n = values.size();
    double mean = 0.0;
    for (const double value : values) mean += value / static_cast<double>(n);
    const auto correlation = [&](std::size_t lag) {
        double sum = 0.0, squares = 0.0;
        for (std::size_t i = 0; i + lag < n; ++i) sum += (values[i] - mean) * (values[i + lag] - mean);
        for (const double value : values) squares += (value - mean) * (value - mean);
        return sum / static_cast<double>(n - lag) / (squares / static_cast<double>(n));
    };
    double tau = 0.5, coherence = 0.5, largest = 0.5;
    bool first = true;
    for (std::size_t window = 1;; ++window) {
        tau += correlation(window);
        coherence += 2.0 * correlation(window) * correlation(window);
        const auto width = static_cast<double>(window);
        const bool last = width >= 5.0 * std::max(tau, coherence) || window >= n / 2;
        if (last || (first && width >= 5.0 * tau)) {
            largest = std::max(largest, tau * (1.0 + (2.0 * width + 1.0) / static_cast<double>(n)));
            first = false;
        }
        if (last) return largest;
    }
}

TEST(StudentProbability, agrees_with_the_closed_forms_of_one_and_two_degrees) {
    EXPECT_NEAR(student_probability(1.0, 1.0), 0.5, 1e-10);                   // Cauchy; Simpson's error at h = 1e-3
    EXPECT_NEAR(student_probability(2.0, 2.0), 2.0 / std::sqrt(6.0), 1e-10);  // t/sqrt(2 + t^2)
}

TEST(AutocorrelationTime, is_the_defining_sum_for_short_and_long_windows) {
    // Windows of some, of hundreds and of thousands of lags: one by one, and by Fourier transform.
    for (const double phi : {-0.3, 0.6, 0.98, 0.998})
        for (const std::size_t size : {50u, 1237u, 8192u}) {
            const std::vector<double> values = autoregression(phi, size, 11);
            const double expected = std::max(0.5, time_by_definition(values));
            EXPECT_NEAR(autocorrelation_time(values), expected, 1e-9 * expected) << phi << " " << size;  // rounding
        }
}

TEST(AutocorrelationTimeLong, of_an_autoregression_has_the_error_of_madras_and_sokal) {
    const int series = 400;
    for (const double phi : {0.5, 0.9, 0.97}) {
        const double exact = exact_time(phi);
        const auto size = static_cast<std::size_t>(1000.0 * exact);
        double sum = 0.0, squares = 0.0;
        for (int s = 0; s < series; ++s) {
            const double ratio =
                autocorrelation_time(autoregression(phi, size, 100 + static_cast<std::uint64_t>(s))) / exact;
            sum += ratio;
            squares += ratio * ratio;
        }
        const double mean = sum / series, deviation = std::sqrt(squares / series - mean * mean);
        // Madras & Sokal: variance 2 (2 W + 1)/n tau^2, here sqrt(0.020) = 0.142, derived for W far beyond tau; at W =
        // 5 tau Wolff's 4 (W + 1/2 - tau)/n gives 0.127.  The deviation of 400 is known to 3.5 %; a window that ends
        // where the noise lets it makes it less.
        EXPECT_LT(deviation, 0.142);
        EXPECT_GT(deviation, 0.7 * 0.142);
        // The window leaves out exp(-5) = 0.7 % of tau; the noise of where it ends is of second order, 0.142^2 = 2 %
        // at most.
        EXPECT_NEAR(mean, 1.0, 0.007 + 0.01 + 4.0 * deviation / std::sqrt(series)) << phi;
    }
}

TEST(AutocorrelationTime, of_constant_short_or_nonfinite_series_is_as_documented) {
    EXPECT_EQ(autocorrelation_time({}), 0.5);
    EXPECT_EQ(autocorrelation_time(std::vector{3.0}), 0.5);
    EXPECT_EQ(autocorrelation_time(std::vector(100, 0.1)), 0.5);
    std::vector<double> damaged(100, 1.0);
    damaged[40] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(autocorrelation_time(damaged)));
    std::vector<double> alternating(100);
    for (std::size_t i = 0; i < alternating.size(); ++i) alternating[i] = i % 2 == 0 ? 1.0 : -1.0;
    // Never below that of independent samples; a series that keeps its phase is summed up to half of its length, of
    // which the last lag counts, and is corrected by a factor of 2.
    EXPECT_GE(autocorrelation_time(alternating), 0.5);
    EXPECT_LE(autocorrelation_time(alternating), 1.01);
}

/// How often the exact mean 0 of 400 series lies within `times` errors of the estimate, and how often it should.
struct Coverage {
    int estimates = 0;
    double within_one = 0.0, within_two = 0.0;      ///< found
    double expected_one = 0.0, expected_two = 0.0;  ///< from Student's t
    double naive_within_one = 0.0;                  ///< with deviation/sqrt(n) for the error
};
Coverage coverage(double phi, std::size_t size, std::uint64_t seed) {
    Coverage result;
    for (std::uint64_t s = 0; s < 400; ++s) {
        const Samples samples{.series = {autoregression(phi, size, seed + s)}};
        const Estimate estimate = estimate_mean(samples, 0);
        if (!estimate.error) continue;
        ++result.estimates;
        const double distance = std::abs(estimate.mean), freedom = static_cast<double>(estimate.blocks) - 1.0;
        result.within_one += distance < *estimate.error ? 1.0 : 0.0;
        result.within_two += distance < 2.0 * *estimate.error ? 1.0 : 0.0;
        result.expected_one += student_probability(1.0, freedom);
        result.expected_two += student_probability(2.0, freedom);
        result.naive_within_one += distance < 1.0 / std::sqrt(static_cast<double>(size)) ? 1.0 : 0.0;
    }
    return result;
}

TEST(Coverage, of_one_and_two_errors_is_that_of_students_t) {
    for (const double phi : {0.0, 0.5, 0.9})
        for (const double times : {1000.0, 250.0}) {  // 64 blocks, and about 25
            const Coverage found = coverage(phi, static_cast<std::size_t>(times * exact_time(phi)), 1000);
            EXPECT_GE(found.estimates, 399);
            // Three binomial deviations: 3 sqrt(400 p (1 - p)) = 28 of 400 at p = 0.68 and 13 at p = 0.95.
            EXPECT_NEAR(found.within_one, found.expected_one, 28.0) << phi << " " << times;
            EXPECT_NEAR(found.within_two, found.expected_two, 13.0) << phi << " " << times;
        }
}

TEST(Coverage, of_an_error_without_correlations_is_too_small) {
    const Coverage found = coverage(0.9, static_cast<std::size_t>(1000.0 * exact_time(0.9)), 1000);
    // It is sqrt(2 tau) = 4.4 times too small: erf(1/4.4/sqrt(2)) = 18 % are within one, 72 of 400.
    EXPECT_NEAR(found.naive_within_one, 72.0, 3.0 * std::sqrt(400.0 * 0.18 * 0.82));
    EXPECT_LT(found.naive_within_one, found.expected_one - 28.0);
}

/// Runs of so many autocorrelation times: which part of 4000 has an error, and how many times it is too small, in the
/// root mean square.
struct Selection {
    double part = 0.0, too_small = 0.0;
};
Selection selection(double times) {
    const double phi = 0.9;
    double estimates = 0.0, squares = 0.0, expected = 0.0;
    for (std::uint64_t s = 0; s < 4000; ++s) {
        const auto size = static_cast<std::size_t>(times * exact_time(phi));
        const Estimate estimate = estimate_mean({.series = {autoregression(phi, size, 20000 + s)}}, 0);
        if (!estimate.error) continue;
        const double distance = estimate.mean / *estimate.error, freedom = static_cast<double>(estimate.blocks) - 1.0;
        estimates += 1.0;
        squares += distance * distance;
        expected += freedom / (freedom - 2.0);
    }
    return {estimates / 4000.0, std::sqrt(squares / expected)};
}

TEST(EstimateLong, errors_of_runs_that_are_long_enough_by_chance_are_too_small) {
    // What accuracy.md states.  Root mean squares of some thousand numbers distributed as Student's t of 7 degrees
    // scatter by 2 %, of a thousand by 4 %.
    const Selection brief = selection(60.0), just = selection(80.0), longer = selection(200.0);
    EXPECT_NEAR(brief.part, 0.27, 0.03);
    EXPECT_NEAR(brief.too_small, 1.3, 0.12);
    EXPECT_NEAR(just.too_small, 1.13, 0.06);
    EXPECT_GT(longer.part, 0.99);
    EXPECT_NEAR(longer.too_small, 1.0, 0.06);
}

TEST(EstimateLong, the_error_is_unbiased_even_with_the_shortest_blocks) {
    const double phi = 0.9, exact = exact_time(phi);
    for (const double times : {700.0, 3000.0}) {  // 64 blocks of 11 and of 47 autocorrelation times
        const auto size = static_cast<std::size_t>(times * exact);
        double ratio = 0.0;
        for (std::uint64_t s = 0; s < 1000; ++s) {
            const Estimate estimate =
                estimate_mean({.series = {autoregression(phi, size, 5000 + s)}, .spacing = 0.25}, 0);
            ASSERT_TRUE(estimate.error);
            // The exact variance of the mean of n samples of a first-order autoregression, but for phi^n.
            const auto n = static_cast<double>(estimate.samples);
            const double variance = 2.0 * exact / n * (1.0 - (exact - 0.25 / exact) / n);
            ratio += *estimate.error * *estimate.error / variance / 1000.0;
        }
        // Three errors of a mean of chi-squares of 63 degrees.  Correlations over the ends of blocks are worth 9 %, 2
        // %; six of 1000 runs whose blocks look correlated by chance, with up to twice the square, 0.6 %.
        EXPECT_NEAR(ratio, 1.0, 3.0 * std::sqrt(2.0 / 63.0 / 1000.0) + 0.006) << times;
    }
}

TEST(Estimate, the_error_is_that_of_independent_block_means) {
    const std::vector<double> values = autoregression(0.9, 1500, 12);
    const Estimate estimate = estimate_mean({.series = {values}, .spacing = 0.25}, 0);
    ASSERT_TRUE(estimate.error);
    ASSERT_LT(estimate.blocks, 24u);  // few, so that blocks - 1 is not as good as blocks
    const std::size_t length = estimate.samples / estimate.blocks, first = values.size() - estimate.samples;
    const auto count = static_cast<double>(estimate.blocks);
    std::vector<double> means(estimate.blocks);
    double mean = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < estimate.samples; ++i)
        means[i / length] += values[first + i] / static_cast<double>(length);
    for (const double block : means) mean += block / count;
    for (const double block : means) sum += (block - mean) * (block - mean);
    const double tau = estimate.autocorrelation_time / 0.25;
    const double lost = (tau - 0.25 / tau) / static_cast<double>(length);  // exact for exponential correlations
    EXPECT_NEAR(estimate.mean, mean, 1e-12);                               // rounding
    EXPECT_NEAR(*estimate.error, std::sqrt(sum / (count - 1.0) / count / (1.0 - lost)), 1e-12);
    EXPECT_GE(static_cast<double>(length), autocorrelation_times_per_block * tau);
}

TEST(Estimate, a_run_that_is_too_short_has_no_error_and_reports_the_run_length_needed) {
    // The spacing is chosen such that the autocorrelation time as measured is 4 s: 80 of them are 320 s.
    const std::vector<double> values = autoregression(0.9, 100, 77);
    const double tau = autocorrelation_time(values), spacing = 4.0 / tau;
    const Estimate estimate = estimate_mean({.series = {values}, .spacing = spacing}, 0);
    EXPECT_FALSE(estimate.error);
    EXPECT_NEAR(estimate.autocorrelation_time, 4.0, 1e-12);  // rounding
    EXPECT_EQ(estimate.samples, 100u);
    const double times = 100.0 / tau;
    EXPECT_EQ(
        estimate.why_no_error,
        text("no error estimate: the run has {:.3g} autocorrelation times ({:.3g} s) after warm-up; expected blocks of "
             "10 each, at least 8 of them: run for 320 s",
             times, times * 4.0));
}

TEST(Estimate, a_run_of_the_reported_length_is_long_enough) {
    const std::vector<double> all = autoregression(0.9, 4000, 21);
    const Estimate brief = estimate_mean({.series = {{all.begin(), all.begin() + 540}}, .skip = 40}, 0);
    ASSERT_FALSE(brief.error);
    const auto asked = static_cast<std::ptrdiff_t>(40.0 + 80.0 * brief.autocorrelation_time);
    EXPECT_THAT(brief.why_no_error, HasSubstr("run for "));
    EXPECT_NEAR(std::stod(brief.why_no_error.substr(brief.why_no_error.rfind("for ") + 4)), static_cast<double>(asked),
                10.0);
    // The time is measured better in the longer run, and may come out longer by its own error, 0.45 tau; twice that is
    // safe.
    EXPECT_TRUE(estimate_mean({.series = {{all.begin(), all.begin() + 2 * asked}}, .skip = 40}, 0).error);
}

TEST(Estimate, a_series_constant_up_to_rounding_has_error_zero) {
    const Estimate constant = estimate_mean({.series = {std::vector(7, 0.1)}, .spacing = 2.0}, 0);
    EXPECT_EQ(constant.mean, 0.1);
    EXPECT_EQ(constant.error, 0.0);
    EXPECT_EQ(constant.autocorrelation_time, 1.0);
    EXPECT_EQ(constant.why_no_error, "");
    std::vector<double> total(1000, 4096.0);  // a conserved total that drifts by rounding
    for (std::size_t i = 1; i < total.size(); ++i) total[i] = total[i - 1] + (i % 3 == 0 ? -1.0 : 1.0) * 4.5e-13;
    EXPECT_EQ(estimate_mean({.series = {total}}, 0).error, 0.0);
}

TEST(Estimate, short_and_nonfinite_series_have_no_error_and_report_why) {
    const auto why_no_error = [](std::vector<double> values, std::size_t skip = 0) {
        const Estimate estimate = estimate_mean({.series = {std::move(values)}, .spacing = 0.5, .skip = skip}, 0);
        EXPECT_FALSE(estimate.error);
        return estimate.why_no_error;
    };
    EXPECT_EQ(why_no_error({}), "no error estimate: 0 samples after warm-up; at least 40 are needed: run for 20 s");
    EXPECT_EQ(why_no_error({1.0}), "no error estimate: one sample after warm-up; at least 40 are needed: run for 20 s");
    EXPECT_EQ(why_no_error({1.0, 2.0}),
              "no error estimate: 2 samples after warm-up; at least 40 are needed: run for 20 s");
    EXPECT_EQ(why_no_error({1.0, 2.0}, 9),
              "no error estimate: 0 samples after warm-up; at least 40 are needed: run for 21 s");
    std::vector<double> damaged(100, 1.0);
    damaged[16] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(
        why_no_error(damaged),
        "no mean: the value is not finite in 1 of 100 samples after warm-up; the first is sample 17, NaN: choose a "
        "longer warm-up, or see the formula for when it is undefined");
    EXPECT_EQ(
        why_no_error(damaged, 10),
        "no mean: the value is not finite in 1 of 90 samples after warm-up; the first is sample 17, NaN: choose a "
        "longer warm-up, or see the formula for when it is undefined");
    EXPECT_EQ(why_no_error(std::vector(3, std::nan(""))), "no mean: the value is undefined (NaN) in every sample");
    EXPECT_TRUE(std::isnan(estimate_mean({.series = {damaged}}, 0).mean));
    EXPECT_EQ(estimate_mean({.series = {damaged}, .skip = 17}, 0).error, 0.0);  // the NaN is in the warm-up
}

TEST(Estimate, series_of_different_lengths_and_a_spacing_of_zero_are_rejected) {
    const auto first = [](std::span<const double> means) { return means[0]; };
    EXPECT_THROW(estimate_function({.series = {{1.0, 2.0}, {1.0}}}, first), Error);
    EXPECT_THROW(estimate_function({.series = {{1.0, 2.0}}, .spacing = 0.0}, first), Error);
    EXPECT_THROW(estimate_function({.series = {}}, first), Error);
}

TEST(Estimate, the_warm_up_is_left_out_and_reported) {
    std::vector<double> values = autoregression(0.0, 1064, 9);
    for (std::size_t i = 0; i < 100; ++i) values[i] = 1e6;
    const Estimate estimate = estimate_mean({.series = {values}, .spacing = 0.5, .skip = 100}, 0);
    ASSERT_TRUE(estimate.error);
    EXPECT_LT(std::abs(estimate.mean), 5.0 * *estimate.error);
    EXPECT_EQ(estimate.warm_up + 0.5 * static_cast<double>(estimate.samples),
              532.0);  // what does not fill a block is warm-up
    EXPECT_GE(estimate.samples, 964u - 63u);
}

TEST(EstimateFunction, the_jackknife_corrects_the_bias_of_a_square) {
    // The square of a sample mean is too large by the variance of the mean; without that the mean over runs is 0.
    const std::size_t runs = 400, size = 640;
    double corrected = 0.0, plain = 0.0;
    for (std::uint64_t s = 0; s < runs; ++s) {
        const Samples samples{.series = {autoregression(0.0, size, 300 + s)}};
        corrected += estimate_function(samples, [](auto means) { return means[0] * means[0]; }).mean / runs;
        plain += std::pow(estimate_mean(samples, 0).mean, 2) / runs;
    }
    const double bias = 1.0 / size, error = std::sqrt(2.0 / runs) * bias;  // of a mean of squares of Gaussians
    EXPECT_NEAR(plain, bias, 4.0 * error + 0.2 * bias);  // samples that fill no block are left out: up to a fifth
    EXPECT_NEAR(corrected, 0.0, 4.0 * error);
}

TEST(EstimateFunction, a_slow_series_sets_the_blocks_for_all) {
    const std::vector<double> fast = autoregression(0.0, 20000, 1), slow = autoregression(0.9, 20000, 2);
    for (const Samples& samples : {Samples{.series = {fast, slow}}, Samples{.series = {slow, fast}}}) {
        const Estimate estimate = estimate_function(samples, [](auto means) { return means[0] * means[1]; });
        EXPECT_EQ(estimate.autocorrelation_time, autocorrelation_time(slow));
    }
}

TEST(EstimateFunction, a_nonfinite_function_has_no_error) {
    const Estimate estimate =
        estimate_local_exponent({.series = {std::vector(100, 0.0), std::vector(100, 0.0)}}, 0, 1, 4.0);
    EXPECT_FALSE(estimate.error);
    EXPECT_THAT(estimate.why_no_error, HasSubstr("is not finite"));
}

/// |P| of a two-component Gaussian of unit variance each, independent samples.
std::vector<double> gaussian_sizes(std::size_t size) {
    std::vector<double> pairs(2 * size), sizes(size);
    fill_normal({.seed = 31, .stream = Stream::test}, 0, 2, pairs);
    for (std::size_t i = 0; i < size; ++i) sizes[i] = std::hypot(pairs[2 * i], pairs[2 * i + 1]);
    return sizes;
}

TEST(OrderParameter, binder_cumulant_of_a_two_component_gaussian_is_one_third) {
    const std::size_t size = 200000;
    const Estimate binder = estimate_binder_cumulant({.series = {gaussian_sizes(size)}}, 0);
    ASSERT_TRUE(binder.error);
    const double exact_error =
        std::sqrt(4.0 / 9.0 / static_cast<double>(size));  // linearised: var(e^2 - 4 e) = 4, e ~ Exp(1)
    EXPECT_NEAR(binder.mean, 1.0 / 3.0, 4.0 * exact_error);
    EXPECT_NEAR(*binder.error, exact_error,
                4.0 * exact_error / std::sqrt(2.0 * 63.0));  // four errors of a deviation of 64
}

TEST(OrderParameter, binder_cumulant_of_perfect_order_is_two_thirds) {
    EXPECT_NEAR(estimate_binder_cumulant({.series = {std::vector(50, 0.7)}}, 0).mean, 2.0 / 3.0, 1e-15);  // rounding
}

TEST(OrderParameter, susceptibility_of_a_two_component_gaussian_is_its_closed_form) {
    const std::size_t size = 200000;
    const Estimate chi = estimate_susceptibility({.series = {gaussian_sizes(size)}}, 0, 9.0);
    ASSERT_TRUE(chi.error);
    const double exact = 9.0 * 2.0 * (1.0 - std::numbers::pi / 4.0);  // area <P^2> (1 - pi/4), <P^2> = 2
    // Relative variance of a sample variance: (kurtosis - 1)/n; Rayleigh: kurtosis 3.245.
    const double exact_error = exact * std::sqrt(2.245 / static_cast<double>(size));
    EXPECT_NEAR(chi.mean, exact, 4.0 * exact_error);
    EXPECT_NEAR(*chi.error, exact_error, 4.0 * exact_error / std::sqrt(2.0 * 63.0));
}

TEST(OrderParameter, susceptibility_of_small_fluctuations_keeps_its_digits) {
    std::vector<double> order = autoregression(0.0, 20000, 8);
    const double plain = estimate_susceptibility({.series = {order}}, 0, 1.0).mean;
    for (double& p : order) p = 1.0 + 1e-9 * p;
    // 1 + 1e-9 p is rounded at 1e-16, 1e-7 of the fluctuation; squaring about zero instead would lose all digits.
    EXPECT_NEAR(estimate_susceptibility({.series = {order}}, 0, 1.0).mean / 1e-18, plain, 1e-5);
}

TEST(LocalExponent, of_power_law_variances_is_the_power) {
    // DN ~ N^0.8 between boxes of N and 4 N; both series fluctuate, one as the other, so that the exponent does not.
    std::vector<double> small = autoregression(0.5, 2000, 4), large(2000);
    for (std::size_t i = 0; i < small.size(); ++i) {
        small[i] = 3.0 + 0.1 * small[i];
        large[i] = small[i] * std::pow(4.0, 1.6);
    }
    const Estimate exponent = estimate_local_exponent({.series = {small, large}}, 0, 1, 4.0);
    EXPECT_NEAR(exponent.mean, 0.8, 1e-12);  // rounding
    ASSERT_TRUE(exponent.error);
    EXPECT_LT(*exponent.error, 1e-12);
}

TEST(LocalExponent, has_the_error_of_the_logarithm_of_a_ratio) {
    std::vector<double> small = autoregression(0.0, 64000, 5), large = autoregression(0.0, 64000, 6);
    for (double& value : small) value = 2.0 + 0.2 * value;
    for (double& value : large) value = 5.0 + 1.0 * value;
    const Estimate exponent = estimate_local_exponent({.series = {small, large}}, 0, 1, 4.0);
    ASSERT_TRUE(exponent.error);
    const double exact =
        std::sqrt((0.01 + 0.04) / 64000.0) / (2.0 * std::log(4.0));  // relative variances 0.1^2 and 0.2^2
    EXPECT_NEAR(exponent.mean, 0.5 * std::log(2.5) / std::log(4.0), 4.0 * exact);
    EXPECT_NEAR(*exponent.error, exact, 4.0 * exact / std::sqrt(2.0 * 63.0));
}

TEST(Deviation, is_the_square_root_of_the_mean_with_half_its_relative_error) {
    std::vector<double> variance = autoregression(0.5, 20000, 4);
    for (double& value : variance) value = 9.0 + value;
    const Samples samples{.series = {variance}};
    const Estimate mean = estimate_mean(samples, 0), deviation = estimate_deviation(samples, 0);
    ASSERT_TRUE(mean.error && deviation.error);
    EXPECT_NEAR(deviation.mean, std::sqrt(mean.mean), 1e-4);  // bias correction: error^2/(8 mean^1.5) = 1e-6
    EXPECT_NEAR(*deviation.error, *mean.error / (2.0 * std::sqrt(mean.mean)), 1e-3 * *deviation.error);  // curvature
}

TEST(WarmUp, of_an_exponential_relaxation_ends_below_the_noise) {
    const double relaxation = 100.0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        std::vector<double> values = autoregression(0.5, 10000, seed);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] += 20.0 * std::exp(-static_cast<double>(i) / relaxation);
        const auto found = static_cast<double>(warm_up_length(values));
        // MSER cuts on average where the rest of the relaxation is as large as the deviation of a batch mean, 0.67
        // here: at i = 100 ln(20/0.67) = 340.  One batch scatters: at i = 230 it stands three deviations above the
        // rest.  A cut past a third of the run would throw data away.
        EXPECT_GT(found, 230.0) << seed;
        EXPECT_LT(found, 3333.0) << seed;
        // What it is for: the mean of the rest is right within its error.
        const Estimate rest = estimate_mean({.series = {values}, .skip = static_cast<std::size_t>(found)}, 0);
        ASSERT_TRUE(rest.error);
        EXPECT_LT(std::abs(rest.mean), 4.0 * *rest.error) << seed;
    }
}

TEST(WarmUp, of_a_stationary_series_is_short_on_average) {
    double mean = 0.0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed)
        mean += static_cast<double>(warm_up_length(autoregression(0.5, 10000, seed))) / 10000.0 / 50.0;
    EXPECT_LT(mean, 0.15);  // some cut there is, by chance: a tenth of the run costs a twentieth of the error
}

TEST(WarmUp, of_an_oscillation_that_decays_lasts_until_it_is_small) {
    // 10 cos(2 pi t/50) exp(-t/100) beside noise of unit variance: its mean is soon that of the rest, but its variance
    // is 50 times as large.  At t = 75 its amplitude is 4.7, and the variance of the rest is larger by 0.3.
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        std::vector<double> values(2000);
        fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, values);
        double last = 0.0;
        for (std::size_t t = 0; t < values.size(); ++t) {
            last = 0.8 * last + 0.6 * values[t];
            values[t] = last + 10.0 * std::cos(2.0 * std::numbers::pi * static_cast<double>(t) / 50.0) *
                                   std::exp(-static_cast<double>(t) / 100.0);
        }
        EXPECT_GT(warm_up_length(values), 75u) << seed;
        EXPECT_LT(warm_up_length(values), 500u) << seed;
    }
}

TEST(WarmUp, of_a_steady_drift_is_half_the_series_and_of_a_constant_zero) {
    std::vector<double> drift(1000);
    for (std::size_t i = 0; i < drift.size(); ++i) drift[i] = static_cast<double>(i);
    EXPECT_EQ(warm_up_length(drift), 500u);
    EXPECT_EQ(warm_up_length(std::vector(1000, 0.1)), 0u);
    EXPECT_EQ(warm_up_length(std::vector{5.0, 1.0, 1.0}), 0u);
    drift[3] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(warm_up_length(drift), 0u);
}

TEST(PairedDifference, of_series_of_different_lengths_is_rejected) {
    const std::vector<double> longer(10, 1.0), shorter(9, 1.0);
    EXPECT_THROW(paired_difference(longer, shorter, 0), Error);
    EXPECT_EQ(paired_difference(longer, longer, 0).value, 0.0);
}

}  // namespace
}  // namespace drover::measure::statistics_tests
