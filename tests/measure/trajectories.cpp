// tests/measure/trajectories.cpp: rotational diffusion and speeds of active Brownian rods with known parameters.
#include "measure/trajectories.hpp"

#include <gtest/gtest.h>

#include "drover/base/error.hpp"
#include "measure/particles_support.hpp"

namespace drover::measure::trajectories_tests {
namespace {

/// Rods with one speed along n whose angle diffuses: exact for the angle; `substeps` midpoint steps between snapshots
/// for the position.
struct Walkers {
    std::vector<std::vector<double>> angles;
    std::vector<Path> paths;
};
Walkers active_rods(std::size_t rods, std::size_t snapshots, double spacing, double diffusion, double speed,
                    std::uint64_t seed, std::size_t substeps = 1) {
    Walkers walkers;
    const double dt = spacing / static_cast<double>(substeps), kick = std::sqrt(2.0 * diffusion * dt);
    const std::vector<double> start = uniform_numbers(rods, seed);
    for (std::size_t r = 0; r < rods; ++r) {
        const std::vector<double> noise = normal_numbers((snapshots - 1) * substeps, seed, r + 1);
        double angle = 2.0 * pi * start[r], x = 0.0, y = 0.0;
        std::vector<double> angles{angle};
        Path path{.x = {x}, .y = {y}};
        for (std::size_t i = 0; i < noise.size(); ++i) {
            const double middle = angle + 0.5 * kick * noise[i];
            x += speed * dt * std::cos(middle);
            y += speed * dt * std::sin(middle);
            angle += kick * noise[i];
            if ((i + 1) % substeps != 0) continue;
            angles.push_back(std::remainder(angle, 2.0 * pi));  // wrapped, as snapshots give it
            path.x.push_back(x);
            path.y.push_back(y);
        }
        walkers.angles.push_back(std::move(angles));
        walkers.paths.push_back(std::move(path));
    }
    return walkers;
}

void expect_within(const Estimate& estimate, double truth, double errors) {
    ASSERT_TRUE(estimate.error.has_value()) << estimate.why_no_error;
    EXPECT_NEAR(estimate.mean, truth, errors * *estimate.error);
}

/// How often intervals of one error (of Student's t) contain the truth, and the deviation of the mean of all from it.
struct Coverage {
    double truth = 0.0, quantile = 1.0;  ///< of t at 68.27 %
    int held = 0, repeats = 0;
    double sum = 0.0, squares = 0.0;
    void add(const Estimate& estimate) {
        ++repeats;
        if (estimate.error && std::abs(estimate.mean - truth) <= quantile * *estimate.error) ++held;
        sum += estimate.mean - truth;
        squares += (estimate.mean - truth) * (estimate.mean - truth);
    }
    /// Within three deviations of the binomial, and of the mean.
    void expect_honest() const {
        const double mean = sum / repeats, error = std::sqrt((squares / repeats - mean * mean) / (repeats - 1));
        EXPECT_NEAR(held, 0.6827 * repeats, 3.0 * std::sqrt(0.6827 * 0.3173 * repeats));
        EXPECT_NEAR(mean, 0.0, 3.0 * error);
    }
};
constexpr double student_19 = 1.027, student_15 = 1.034;  // 68.27 % of t: 1 + 2/(4 n) + 24/(96 n^2), n degrees

TEST(RotationalCorrelation, of_rods_that_turn_uniformly_is_the_cosine_of_the_angle) {
    std::vector<std::vector<double>> angles(3);
    for (int i = 0; i < 100; ++i)
        for (std::size_t r = 0; r < 3; ++r)
            angles[r].push_back(std::remainder(0.3 * i + 2.0 * static_cast<double>(r), 2.0 * pi));
    const RotationalCorrelation correlation = rotational_correlation(angles, 0.5, 20);
    ASSERT_EQ(correlation.values.size(), 21u);
    for (std::size_t lag = 0; lag <= 20; ++lag) {
        EXPECT_EQ(correlation.times[lag], 0.5 * static_cast<double>(lag));
        EXPECT_NEAR(correlation.values[lag].mean, std::cos(0.3 * static_cast<double>(lag)), 1e-12);  // rounding
    }
}

TEST(RotationalCorrelation, of_diffusing_rods_decays_exponentially) {
    const Walkers walkers = active_rods(40, 2001, 0.05, 0.4, 3.6, 21);
    const RotationalCorrelation correlation = rotational_correlation(walkers.angles, 0.05, 200);
    for (const std::size_t lag : {1u, 5u, 20u, 60u, 120u})
        expect_within(correlation.values[lag], std::exp(-0.4 * 0.05 * static_cast<double>(lag)), 3.0);
    EXPECT_FALSE(correlation.by_time);
}

TEST(RotationalCorrelation, accepts_rods_followed_for_different_times) {
    Walkers walkers = active_rods(20, 1000, 0.05, 0.4, 0.0, 22);
    walkers.angles[3].resize(40);
    walkers.angles[7].clear();
    const RotationalCorrelation correlation = rotational_correlation(walkers.angles, 0.05, 100);
    expect_within(correlation.values[80], std::exp(-0.4 * 4.0), 3.0);
    EXPECT_EQ(correlation.values[80].blocks, 18u);  // one has no pair so far apart, one has none at all
    EXPECT_EQ(correlation.values[10].blocks, 19u);
}

TEST(RotationalDiffusion, excludes_the_initial_loss_by_jitter) {
    Walkers walkers = active_rods(40, 2001, 0.05, 0.4, 0.0, 23);
    for (std::size_t r = 0; r < 40; ++r) {
        const std::vector<double> noise = normal_numbers(2001, 24, r);
        for (std::size_t i = 0; i < 2001; ++i) walkers.angles[r][i] += 0.2 * noise[i];
    }
    const RotationalDiffusion found = rotational_diffusion(rotational_correlation(walkers.angles, 0.05, 200));
    expect_within(found.diffusion, 0.4, 3.0);
    expect_within(found.relaxation_time, 2.5, 3.0);
    // exp(-0.04) is lost: twice a variance of 0.04, halved.  TableEntry as well as the angle differences: some 80,000.
    EXPECT_NEAR(found.fast, 1.0 - std::exp(-0.04), 0.002);
    EXPECT_LE(found.to, 0.5 / 0.4 + 0.2);  // where -ln C passes one half
}

TEST(RotationalDiffusion, is_that_of_long_times_for_a_rod_with_correlated_angular_velocity) {
    // Angular velocity of memory 0.03 s, seen every 5 ms: <dtheta^2> = 2 D (t - memory (1 - exp(-t/memory))), so 2 D t
    // less a constant.
    const double diffusion = 0.4, memory = 0.03, dt = 0.005, keep = std::exp(-dt / memory);
    std::vector<std::vector<double>> angles(40);
    for (std::size_t r = 0; r < 40; ++r) {
        const std::vector<double> noise = normal_numbers(8001, 28, r);
        double turning = std::sqrt(diffusion / memory) * noise[0], angle = 0.0;
        for (std::size_t i = 1; i < 8001; ++i) {
            angles[r].push_back(angle);
            angle += turning * dt;
            turning = keep * turning + std::sqrt(diffusion / memory * (1.0 - keep * keep)) * noise[i];
        }
    }
    // Of steps of 5 ms the sum of the correlations is not quite the integral: dt coth(dt/(2 memory))/2 for the memory.
    const double expected = diffusion / memory * 0.5 * dt / std::tanh(0.5 * dt / memory);
    const RotationalDiffusion found = rotational_diffusion(rotational_correlation(angles, dt, 400));
    expect_within(found.diffusion, expected, 3.0);
    EXPECT_LT(*found.diffusion.error, 0.05 * expected);
    EXPECT_LT(found.fast, 0.0);  // C starts flat: above its exponential
}

TEST(RotationalDiffusion, of_rods_that_do_not_turn_is_zero_and_has_no_relaxation_time) {
    const std::vector<std::vector<double>> angles(20, std::vector<double>(50, 0.0));
    const RotationalDiffusion found = rotational_diffusion(rotational_correlation(angles, 0.1, 20));
    EXPECT_NEAR(found.diffusion.mean, 0.0, 1e-14);
    EXPECT_TRUE(std::isinf(found.relaxation_time.mean) || found.relaxation_time.mean > 1e12);
}

TEST(RotationalDiffusion, has_no_error_where_it_cannot_be_estimated) {
    const Walkers one = active_rods(1, 400, 0.05, 0.4, 0.0, 26);  // 20 s: 16 segments of half a relaxation time
    const RotationalDiffusion brief = rotational_diffusion(rotational_correlation(one.angles, 0.05, 100));
    EXPECT_FALSE(brief.diffusion.error.has_value());
    EXPECT_NE(brief.diffusion.why_no_error.find("relaxation times"), std::string::npos) << brief.diffusion.why_no_error;
    EXPECT_FALSE(brief.relaxation_time.error.has_value());
    const Walkers coarse = active_rods(20, 400, 5.0, 0.4, 0.0, 27);
    const RotationalDiffusion none = rotational_diffusion(rotational_correlation(coarse.angles, 5.0, 100));
    EXPECT_FALSE(none.diffusion.error.has_value());
    EXPECT_NE(none.diffusion.why_no_error.find("sample more often"), std::string::npos) << none.diffusion.why_no_error;
    const RotationalDiffusion nothing = rotational_diffusion(rotational_correlation({}, 0.05, 100));
    EXPECT_FALSE(nothing.diffusion.error.has_value());
}

TEST(RotationalDiffusionStatistics, of_twenty_rods_is_unbiased_and_its_errors_have_the_nominal_coverage) {
    Coverage diffusion{.truth = 0.4, .quantile = student_19};
    for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
        const Walkers walkers = active_rods(20, 801, 0.05, 0.4, 0.0, 1000 + repeat);  // 16 relaxation times each
        diffusion.add(rotational_diffusion(rotational_correlation(walkers.angles, 0.05, 40)).diffusion);
    }
    diffusion.expect_honest();
}

TEST(RotationalDiffusionStatistics, of_one_rod_has_errors_from_segments_of_time) {
    Coverage diffusion{.truth = 0.4, .quantile = student_15},
        correlation{.truth = std::exp(-0.4), .quantile = student_15};
    for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
        const Walkers walkers =
            active_rods(1, 20001, 0.05, 0.4, 0.0, 3000 + repeat);  // segments of 25 relaxation times
        const RotationalCorrelation found = rotational_correlation(walkers.angles, 0.05, 40);
        EXPECT_TRUE(found.by_time);
        diffusion.add(rotational_diffusion(found).diffusion);
        correlation.add(found.values[20]);
    }
    diffusion.expect_honest();
    correlation.expect_honest();
}

TEST(SpeedsAlong, of_a_straight_path_are_its_speed_despite_vibration) {
    std::vector<Path> paths(1);
    std::vector<std::vector<double>> angles(1);
    for (int i = 0; i <= 40; ++i) {  // frames of 25 ms, five periods of the plates: always at the same phase
        const double s = 3.6 * 0.025 * i + 0.01 * std::sin(2.0 * pi * 5 * i + 0.3);
        paths[0].x.push_back(s * std::cos(2.0));
        paths[0].y.push_back(s * std::sin(2.0));
        angles[0].push_back(2.0);
    }
    const Speeds speeds = speeds_along(paths, angles, 0.025);
    EXPECT_NEAR(speeds.mean.mean, 3.6, 1e-10);          // positions of some mm over 0.025 s
    EXPECT_LE(speeds.mean.error.value_or(1.0), 1e-10);  // one rod: over time
}

TEST(SpeedsAlong, of_rods_that_turn_is_reduced_as_predicted) {
    const double diffusion = 0.8, frame = 0.25, turned = diffusion * frame;  // slow frames: 0.2 of a relaxation time
    const Walkers walkers = active_rods(100, 81, frame, diffusion, 3.6, 31, 100);
    expect_within(speeds_along(walkers.paths, walkers.angles, frame).mean, 3.6 * (1.0 - std::exp(-turned)) / turned,
                  3.0);
}

TEST(SpeedsAlong, of_unequal_rods_has_the_standard_error_of_their_means) {
    std::vector<Path> paths;
    std::vector<std::vector<double>> angles;
    const std::vector<double> speeds_drawn = normal_numbers(150, 33);
    double sum = 0.0, squares = 0.0;
    for (const double z : speeds_drawn) {
        const double v = 3.6 + 2.5 * z;
        Path path;
        for (int i = 0; i <= 40; ++i) path.x.push_back(v * 0.025 * i), path.y.push_back(1.0);
        paths.push_back(std::move(path));
        angles.emplace_back(41, 0.0);
        sum += v / 150.0;
        squares += v * v;
    }
    const Speeds speeds = speeds_along(paths, angles, 0.025);
    const double spread = std::sqrt((squares - 150.0 * sum * sum) / 149.0);
    EXPECT_NEAR(speeds.mean.mean, sum, 1e-10);
    ASSERT_EQ(speeds.of_rods.size(), 150u);
    EXPECT_NEAR(speeds.of_rods[7], 3.6 + 2.5 * speeds_drawn[7], 1e-10);
    ASSERT_TRUE(speeds.mean.error.has_value());
    // The jackknife of a mean is its standard error; rounding in sums of squares.
    EXPECT_NEAR(*speeds.mean.error, spread / std::sqrt(150.0), 1e-10);
}

/// Straight rods along x with these mean speeds, and noise of 1 mm/s in each of the frames.
double scatter_of_rods(const std::vector<double>& means, std::size_t frames) {
    std::vector<Path> paths;
    for (std::size_t r = 0; r < means.size(); ++r) {
        const std::vector<double> noise = normal_numbers(frames, 40 + r);
        Path path{.x = {0.0}, .y = std::vector<double>(frames + 1, 0.0)};
        for (const double one : noise) path.x.push_back(path.x.back() + 0.1 * (means[r] + one));
        paths.push_back(std::move(path));
    }
    const std::vector<std::vector<double>> angles(means.size(), std::vector<double>(frames + 1, 0.0));
    return speeds_along(paths, angles, 0.1).scatter;
}

TEST(SpeedsAlong, scatter_as_their_errors_where_rods_are_alike_and_by_more_in_two_gaits) {
    // Chi-square of 19 degrees over 19 has a deviation of 0.32, and its root half of that.
    EXPECT_NEAR(scatter_of_rods(std::vector<double>(20, 5.0), 400), 1.0, 0.5);
    // +-2 mm/s with errors of 1/20 mm/s, known to a tenth from at most 64 blocks.
    std::vector<double> gaits(20, 3.0);
    for (std::size_t r = 0; r < 10; ++r) gaits[r] = 7.0;
    EXPECT_NEAR(scatter_of_rods(gaits, 400), 2.0 * 20.0 * std::sqrt(20.0 / 19.0), 10.0);
    EXPECT_TRUE(std::isnan(scatter_of_rods({3.0, 7.0, 3.0}, 400)));
    EXPECT_TRUE(std::isnan(scatter_of_rods(std::vector<double>(20, 5.0), 10)));
}

TEST(SpeedsAlongStatistics, has_errors_with_the_nominal_coverage) {
    Coverage speed{.truth = 3.6, .quantile = student_19};
    for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
        const Walkers walkers = active_rods(20, 401, 0.025, 0.0, 3.6, 5000 + repeat);
        std::vector<Path> paths = walkers.paths;
        const std::vector<double> noise = normal_numbers(20 * 401 * 2, 5000 + repeat, 99);
        double x = 0.0, y = 0.0;
        for (std::size_t i = 0; i < 20 * 401; ++i) {  // and a random walk of 0.05 mm a frame
            if (i % 401 == 0) x = y = 0.0;
            paths[i / 401].x[i % 401] += x += 0.05 * noise[2 * i];
            paths[i / 401].y[i % 401] += y += 0.05 * noise[2 * i + 1];
        }
        speed.add(speeds_along(paths, walkers.angles, 0.025).mean);
    }
    speed.expect_honest();
}

TEST(SpeedsAlong, reject_angles_of_other_rods_and_a_spacing_of_zero) {
    const std::vector<Path> paths(2);
    EXPECT_THROW(speeds_along(paths, std::vector<std::vector<double>>(1), 0.1), Error);
    EXPECT_THROW(speeds_along(paths, std::vector<std::vector<double>>(2), 0.0), Error);
    EXPECT_FALSE(speeds_along(paths, std::vector<std::vector<double>>(2), 0.1).mean.error.has_value());
    EXPECT_FALSE(speeds_along({}, {}, 0.1).mean.error.has_value());
}

}  // namespace
}  // namespace drover::measure::trajectories_tests
