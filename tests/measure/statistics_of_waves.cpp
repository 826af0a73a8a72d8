// tests/measure/statistics_of_waves.cpp: errors of series that oscillate against the exact statistics of a damped wave.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <tuple>

#include "drover/base/random.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::measure::wave_statistics_tests {
namespace {

/// A rotating and decaying complex number with white noise: <z_i z_(i+k)*> = 2 e^(-k/decay - i omega k).
std::vector<std::complex<double>> complex_wave(double decay, double omega, std::size_t size, std::uint64_t seed) {
    std::vector<double> noise(2 * size);
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, noise);
    const std::complex<double> turn = std::exp(std::complex(-1.0 / decay, omega));
    std::vector<std::complex<double>> values{{noise[0], noise[1]}};
    for (std::size_t i = 1; i < size; ++i)
        values.push_back(turn * values.back() +
                         std::sqrt(1.0 - std::norm(turn)) * std::complex(noise[2 * i], noise[2 * i + 1]));
    return values;
}

/// Its real part: rho_k = e^(-k/decay) cos(omega k).
std::vector<double> damped_wave(double decay, double omega, std::size_t size, std::uint64_t seed) {
    std::vector<double> values;
    for (const std::complex<double>& z : complex_wave(decay, omega, size, seed)) values.push_back(z.real());
    return values;
}

TEST(CorrelationTimes, of_a_damped_wave_are_its_sums) {
    // rho_k = e^(-k/T) cos(omega k): 1/2 + sum rho_k = 1/2 + Re z/(1 - z) with z = e^(-1/T + i omega), and sum rho_k^2
    // = (sum e^(-2k/T) + Re sum z^2k)/2.  Relative errors by Madras and Sokal: sqrt(2 (2 W + 1)/n), W = 5 * 10.
    const double decay = 20.0, omega = 0.6;
    const std::complex<double> z = std::exp(std::complex(-1.0 / decay, omega)), zz = z * z;
    const double envelope = std::exp(-2.0 / decay) / (1.0 - std::exp(-2.0 / decay));
    const CorrelationTimes times = correlation_times(damped_wave(decay, omega, 200000, 5));
    EXPECT_NEAR(times.coherence, 0.5 + envelope + (zz / (1.0 - zz)).real(), 0.1 * times.coherence);
    EXPECT_EQ(times.integrated, 0.5);  // 0.5 + Re z/(1 - z) = 0.14: fewer samples would be as good
    EXPECT_LT(0.5 + (z / (1.0 - z)).real(), 0.15);
}

/// The variance of the mean of n samples of damped_wave(), times n.
double mean_square(double decay, double omega, double n) {
    double sum = 1.0;
    for (double k = 1.0; k < n; ++k) sum += 2.0 * (1.0 - k / n) * std::exp(-k / decay) * std::cos(omega * k);
    return sum;
}

TEST(EstimateLong, the_error_of_a_damped_wave_is_not_too_large_in_a_short_run) {
    // 25 decay times of a wave that turns 12 rad in each.  Blocks of ten integrated times, less than a period, would
    // give an error more than twice too large; the longest, of three decay times, still cut waves: their means have the
    // exact variance mean_square()/length.
    const double decay = 20.0, omega = 0.6;
    double ratio = 0.0, expected = 0.0;
    const int runs = 400;
    for (int s = 0; s < runs; ++s) {
        const Estimate estimate =
            estimate_mean({.series = {damped_wave(decay, omega, 500, 900 + static_cast<std::uint64_t>(s))}}, 0);
        ASSERT_TRUE(estimate.error);
        const auto n = static_cast<double>(estimate.samples), blocks = static_cast<double>(estimate.blocks);
        const double exact = mean_square(decay, omega, n) / n;
        ratio += *estimate.error * *estimate.error / exact / runs;
        expected += mean_square(decay, omega, n / blocks) / n / exact / runs;
    }
    // Three errors of a mean of chi-squares of 7 degrees; means of neighbouring blocks are correlated by a tenth.
    EXPECT_NEAR(ratio, expected, (0.1 + 3.0 * std::sqrt(2.0 / 7.0 / runs)) * expected);
    EXPECT_LT(ratio, 2.0);  // an error at most 1.4 times too large
}

TEST(EstimateLong, the_error_of_a_wave_and_its_power_is_right_after_50_decay_times_and_too_small_after_20) {
    // x + (x^2 + y^2)/2 of a wave x + i y of variance 2: its correlations are e^(-k/T) cos(omega k) + e^(-2k/T).
    const double decay = 20.0, omega = 0.6;
    for (const auto& [times, min, max] : {std::tuple{50.0, 0.8, 1.2}, std::tuple{20.0, 0.35, 0.7}}) {
        const auto size = static_cast<std::size_t>(times * decay);
        double ratio = 0.0, count = 0.0;
        for (std::uint64_t s = 0; s < 400; ++s) {
            std::vector<double> values;
            for (const std::complex<double>& z : complex_wave(decay, omega, size, 3000 + s))
                values.push_back(z.real() + std::norm(z) / 2.0);
            const Estimate estimate = estimate_mean({.series = {values}}, 0);
            if (!estimate.error) continue;
            const auto n = static_cast<double>(estimate.samples);
            double sum = 2.0;
            for (double k = 1.0; k < n; ++k)
                sum += 2.0 * (1.0 - k / n) * (std::exp(-k / decay) * std::cos(omega * k) + std::exp(-2.0 * k / decay));
            ratio += *estimate.error * *estimate.error / (sum / n);
            count += 1.0;
        }
        EXPECT_GT(ratio / count, min) << times;
        EXPECT_LT(ratio / count, max) << times;
        EXPECT_GT(count, 200.0);
    }
}

/// White noise with a twentieth of its variance in a change that decays in 200 samples.
std::vector<double> noise_over_slow_change(std::size_t size, std::uint64_t seed) {
    std::vector<double> noise(2 * size), values;
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 2, noise);
    const double rate = std::exp(-1.0 / 200.0);
    double slow = noise[0];
    for (std::size_t i = 0; i < size; ++i) {
        if (i > 0) slow = rate * slow + std::sqrt(1.0 - rate * rate) * noise[2 * i];
        values.push_back(std::sqrt(0.95) * noise[2 * i + 1] + std::sqrt(0.05) * slow);
    }
    return values;
}

TEST(Estimate, an_error_sees_a_slow_change_below_fast_noise) {
    // The variance of the mean is 0.95/n + 0.05 (2 tau/n)(1 - tau/n), tau = 200.5.  200 series give its root to 5 %.
    const double size = 4000.0, tau = 200.5, exact = std::sqrt(0.95 / size + 0.1 * tau / size * (1.0 - tau / size));
    double squares = 0.0;
    for (std::uint64_t s = 0; s < 200; ++s)
        squares +=
            std::pow(estimate_mean({.series = {noise_over_slow_change(static_cast<std::size_t>(size), 7000 + s)}}, 0)
                         .error.value(),
                     2);
    const double ratio = std::sqrt(squares / 200.0) / exact;
    EXPECT_GT(ratio, 0.8);  // 0.4 from blocks that count as independent
    EXPECT_LT(ratio, 1.25);
}

TEST(Estimate, independent_samples_have_the_error_of_independent_blocks) {
    double squares = 0.0;
    for (std::uint64_t s = 0; s < 200; ++s) {
        std::vector<double> noise(2000);
        fill_normal({.seed = 9000 + s, .stream = Stream::test}, 3, 1, noise);
        squares += std::pow(estimate_mean({.series = {noise}}, 0).error.value(), 2) * 2000.0;
    }
    EXPECT_NEAR(squares / 200.0, 1.0, 0.06);  // of 64 blocks each: 1.3 %, and 1 % of blocks that look correlated
}

}  // namespace
}  // namespace drover::measure::wave_statistics_tests
