// tests/measure/trajectories.cpp: rotational diffusion, speeds and displacements of active Brownian rods of known numbers.
#include "drover/measure/trajectories.hpp"

#include <gtest/gtest.h>

#include "drover/base/error.hpp"
#include "measure/particles_support.hpp"

namespace drover::measure {
namespace {

/// Rods of one speed along n, whose angle diffuses: exact for the angle, `parts` midpoint steps between snapshots for the place.
struct Walkers {
    std::vector<std::vector<double>> angles;
    std::vector<Path> paths;
};
Walkers active_rods(std::size_t rods, std::size_t snapshots, double spacing, double diffusion, double speed,
                    std::uint64_t seed, std::size_t parts = 1) {
    Walkers walkers;
    const double dt = spacing / static_cast<double>(parts), kick = std::sqrt(2.0 * diffusion * dt);
    const std::vector<double> start = uniform_numbers(rods, seed);
    for (std::size_t r = 0; r < rods; ++r) {
        const std::vector<double> noise = normal_numbers((snapshots - 1) * parts, seed, r + 1);
        double angle = 2.0 * pi * start[r], x = 0.0, y = 0.0;
        std::vector<double> angles{angle};
        Path path{.x = {x}, .y = {y}};
        for (std::size_t i = 0; i < noise.size(); ++i) {
            const double middle = angle + 0.5 * kick * noise[i];
            x += speed * dt * std::cos(middle);
            y += speed * dt * std::sin(middle);
            angle += kick * noise[i];
            if ((i + 1) % parts != 0) continue;
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
    ASSERT_TRUE(estimate.error.has_value()) << estimate.refusal;
    EXPECT_NEAR(estimate.mean, truth, errors * *estimate.error);
}

/// How often intervals of one error (of Student's t) hold the truth, and how far the mean of all is from it in its own errors.
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

TEST(RotationalCorrelation, of_rods_that_turn_evenly_is_the_cosine_of_the_turn) {
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

TEST(RotationalCorrelation, of_diffusing_rods_falls_as_an_exponential) {
    const Walkers walkers = active_rods(40, 2001, 0.05, 0.4, 3.6, 21);
    const RotationalCorrelation correlation = rotational_correlation(walkers.angles, 0.05, 200);
    for (const std::size_t lag : {1u, 5u, 20u, 60u, 120u})
        expect_within(correlation.values[lag], std::exp(-0.4 * 0.05 * static_cast<double>(lag)), 3.0);
    EXPECT_FALSE(correlation.by_time);
}

TEST(RotationalCorrelation, takes_rods_followed_for_unlike_times) {
    Walkers walkers = active_rods(20, 1000, 0.05, 0.4, 0.0, 22);
    walkers.angles[3].resize(40);
    walkers.angles[7].clear();
    const RotationalCorrelation correlation = rotational_correlation(walkers.angles, 0.05, 100);
    expect_within(correlation.values[80], std::exp(-0.4 * 4.0), 3.0);
    EXPECT_EQ(correlation.values[80].blocks, 18u);  // one has no pair so far apart, one has none at all
    EXPECT_EQ(correlation.values[10].blocks, 19u);
}

TEST(RotationalDiffusion, leaves_out_what_is_lost_at_once_to_jitter) {
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

TEST(RotationalDiffusion, is_that_of_long_times_for_a_rod_that_remembers_how_fast_it_turned) {
    // Angular velocity of memory 0.03 s, seen every 5 ms: <dtheta^2> = 2 D (t - memory (1 - exp(-t/memory))), so 2 D t less a constant.
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
    const RotationalCorrelation correlation = rotational_correlation(angles, dt, 400);
    const RotationalDiffusion found = rotational_diffusion(correlation);
    expect_within(found.diffusion, expected, 3.0);
    EXPECT_LT(*found.diffusion.error, 0.05 * expected);  // and that is not for want of precision:
    EXPECT_LT(rotational_diffusion(correlation, {.from = dt, .to = 0.03}).diffusion.mean, 0.8 * expected);
    EXPECT_LT(found.fast, 0.0);  // C starts flat: above its exponential
}

TEST(RotationalDiffusion, starts_where_it_is_told_to) {
    const Walkers walkers = active_rods(20, 1001, 0.05, 0.4, 0.0, 25);
    const RotationalCorrelation correlation = rotational_correlation(walkers.angles, 0.05, 200);
    const RotationalDiffusion found = rotational_diffusion(correlation, {.from = 0.3, .to = 0.9});
    EXPECT_NEAR(found.from, 0.3, 1e-12);
    EXPECT_NEAR(found.to, 0.9, 1e-12);
    EXPECT_EQ(found.lags, 13u);
    expect_within(found.diffusion, 0.4, 3.0);
}

TEST(RotationalDiffusion, of_rods_that_do_not_turn_is_zero_and_has_no_relaxation_time) {
    const std::vector<std::vector<double>> angles(20, std::vector<double>(50, 0.0));
    const RotationalDiffusion found = rotational_diffusion(rotational_correlation(angles, 0.1, 20));
    EXPECT_NEAR(found.diffusion.mean, 0.0, 1e-14);
    EXPECT_TRUE(std::isinf(found.relaxation_time.mean) || found.relaxation_time.mean > 1e12);
}

TEST(RotationalDiffusion, has_no_error_where_none_can_be_known) {
    const Walkers one = active_rods(1, 400, 0.05, 0.4, 0.0, 26);  // 20 s: 16 stretches of half a relaxation time
    const RotationalDiffusion brief = rotational_diffusion(rotational_correlation(one.angles, 0.05, 100));
    EXPECT_FALSE(brief.diffusion.error.has_value());
    EXPECT_NE(brief.diffusion.refusal.find("relaxation times"), std::string::npos) << brief.diffusion.refusal;
    EXPECT_FALSE(brief.relaxation_time.error.has_value());
    const Walkers coarse = active_rods(20, 400, 5.0, 0.4, 0.0, 27);
    const RotationalDiffusion none = rotational_diffusion(rotational_correlation(coarse.angles, 5.0, 100));
    EXPECT_FALSE(none.diffusion.error.has_value());
    EXPECT_NE(none.diffusion.refusal.find("sample more often"), std::string::npos) << none.diffusion.refusal;
    const RotationalDiffusion nothing = rotational_diffusion(rotational_correlation({}, 0.05, 100));
    EXPECT_FALSE(nothing.diffusion.error.has_value());
}

TEST(RotationalDiffusionStatistics, of_twenty_rods_is_right_and_its_errors_hold_the_truth_as_often_as_they_say) {
    Coverage diffusion{.truth = 0.4, .quantile = student_19};
    for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
        const Walkers walkers = active_rods(20, 801, 0.05, 0.4, 0.0, 1000 + repeat);  // 16 relaxation times each
        diffusion.add(rotational_diffusion(rotational_correlation(walkers.angles, 0.05, 40)).diffusion);
    }
    diffusion.expect_honest();
}

TEST(RotationalDiffusionStatistics, of_one_rod_has_errors_from_stretches_of_time) {
    Coverage diffusion{.truth = 0.4, .quantile = student_15},
        correlation{.truth = std::exp(-0.4), .quantile = student_15};
    for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
        const Walkers walkers =
            active_rods(1, 20001, 0.05, 0.4, 0.0, 3000 + repeat);  // stretches of 25 relaxation times
        const RotationalCorrelation found = rotational_correlation(walkers.angles, 0.05, 40);
        EXPECT_TRUE(found.by_time);
        diffusion.add(rotational_diffusion(found).diffusion);
        correlation.add(found.values[20]);
    }
    diffusion.expect_honest();
    correlation.expect_honest();
}

TEST(SpeedsAlong, of_a_rod_that_goes_straight_are_its_speed_however_it_rattles) {
    std::vector<Path> paths(1);
    std::vector<std::vector<double>> angles(1);
    for (int i = 0; i <= 200; ++i) {  // every 5 ms, the period of the plates, at one phase
        const double s = 3.6 * 0.005 * i + 0.01 * std::sin(2.0 * pi * i + 0.3);
        paths[0].x.push_back(s * std::cos(2.0));
        paths[0].y.push_back(s * std::sin(2.0));
        angles[0].push_back(2.0);
    }
    const Speeds speeds = speeds_along(paths, angles, 0.005, 5);
    EXPECT_NEAR(speeds.frame, 0.025, 1e-15);
    EXPECT_NEAR(speeds.along_start.mean, 3.6, 1e-10);  // places of some mm over 0.025 s
    EXPECT_NEAR(speeds.along_mean.mean, 3.6, 1e-10);
    EXPECT_EQ(speeds.of_frames.size(), 40u);
    EXPECT_NEAR(speeds.spread_of_frames, 0.0, 1e-10);
    EXPECT_EQ(speeds.along_mean.blocks, min_units);  // one rod: stretches of time
}

TEST(SpeedsAlong, lose_to_turning_what_theory_says) {
    const double diffusion = 0.8, frame = 0.25, lost = diffusion * frame;  // slow frames: 0.2 of a relaxation time
    const Walkers walkers = active_rods(100, 801, 0.025, diffusion, 3.6, 31, 10);
    const Speeds speeds = speeds_along(walkers.paths, walkers.angles, 0.025, 10);
    expect_within(speeds.along_start, 3.6 * (1.0 - std::exp(-lost)) / lost, 3.0);
    // The next term of 1 - lost/6, of order lost^2/60, is a tenth of a percent of the speed, beside errors of some hundredths of a percent.
    EXPECT_NEAR(speeds.along_mean.mean, 3.6 * (1.0 - lost / 6.0),
                3.0 * *speeds.along_mean.error + 3.6 * lost * lost / 60.0);
}

TEST(SpeedsAlong, find_the_spread_among_rods) {
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
    const Speeds speeds = speeds_along(paths, angles, 0.025, 1);
    const double spread = std::sqrt((squares - 150.0 * sum * sum) / 149.0);
    EXPECT_NEAR(speeds.along_mean.mean, sum, 1e-10);
    EXPECT_NEAR(speeds.spread_of_rods, spread, 1e-10);  // rounding, in sums of squares
    ASSERT_TRUE(speeds.along_mean.error.has_value());
    EXPECT_NEAR(*speeds.along_mean.error, spread / std::sqrt(150.0),
                1e-10);  // the jackknife of a mean is its standard error
}

TEST(SpeedsAlongStatistics, have_errors_that_hold_the_truth_as_often_as_they_say) {
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
        speed.add(speeds_along(paths, walkers.angles, 0.025, 1).along_mean);
    }
    speed.expect_honest();
}

TEST(SpeedsAlong, refuse_what_does_not_fit) {
    const std::vector<Path> paths(2);
    EXPECT_THROW(speeds_along(paths, std::vector<std::vector<double>>(1), 0.1, 1), Error);
    EXPECT_THROW(speeds_along(paths, std::vector<std::vector<double>>(2), 0.1, 0), Error);
    EXPECT_FALSE(speeds_along(paths, std::vector<std::vector<double>>(2), 0.1, 1).along_mean.error.has_value());
    EXPECT_FALSE(speeds_along({}, {}, 0.1, 1).along_mean.error.has_value());
}

std::vector<Path> random_walks(std::size_t bodies, std::size_t snapshots, double step, double drift,
                               std::uint64_t seed) {
    std::vector<Path> paths(bodies);
    for (std::size_t b = 0; b < bodies; ++b) {
        const std::vector<double> noise = normal_numbers(2 * snapshots, seed, b);
        double x = 0.0, y = 0.0;
        for (std::size_t i = 0; i < snapshots; ++i) {
            paths[b].x.push_back(x += drift + step * noise[2 * i]);
            paths[b].y.push_back(y += step * noise[2 * i + 1]);
        }
    }
    return paths;
}

TEST(MeanSquareDisplacement, of_random_walks_grows_evenly_and_drift_can_be_taken_out) {
    const std::vector<Path> paths = random_walks(200, 300, 0.1, 0.05, 41);
    const Displacement still = mean_square_displacement(paths, 0.5, 50, true),
                       drifting = mean_square_displacement(paths, 0.5, 50);
    for (const std::size_t lag : {1u, 10u, 50u}) {
        const auto steps = static_cast<double>(lag);
        EXPECT_EQ(still.times[lag], 0.5 * steps);
        expect_within(still.values[lag], 0.02 * steps * (1.0 - 1.0 / 200.0), 3.0);  // the mean of 200 walks with it
        expect_within(drifting.values[lag], 0.02 * steps + 0.0025 * steps * steps, 3.0);
    }
    EXPECT_EQ(still.values[0].mean, 0.0);
}

TEST(MeanSquareDisplacementStatistics, has_errors_that_hold_the_truth_as_often_as_they_say) {
    Coverage displacement{.truth = 0.02 * 5.0, .quantile = student_19};
    for (std::uint64_t repeat = 0; repeat < 200; ++repeat)
        displacement.add(mean_square_displacement(random_walks(20, 300, 0.1, 0.0, 7000 + repeat), 0.5, 5).values[5]);
    displacement.expect_honest();
}

TEST(Trajectory, follows_the_bodies_of_its_snapshots) {
    ParticleScene scene = random_particles(9, 5000, 3);
    Trajectory trajectory;
    for (int i = 0; i < 4; ++i) {
        add_snapshot(trajectory, 1.0 + 0.1 * i, scene.bodies);
        for (dem::Rod& rod : scene.bodies.rods) rod.position = rod.position + 0.1 * rod.velocity;
        for (dem::Bead& bead : scene.bodies.beads) bead.position = bead.position + 0.1 * bead.velocity;
    }
    EXPECT_EQ(trajectory.snapshots, 4u);
    EXPECT_NEAR(trajectory.spacing, 0.1, 1e-12);
    ASSERT_EQ(trajectory.rods.size(), 3u);
    const dem::Rod& rod = scene.bodies.rods[2];
    EXPECT_NEAR(trajectory.angles[2][3], std::atan2(rod.axis.y, rod.axis.x), 1e-15);
    EXPECT_NEAR(trajectory.rods[2].x[3] - trajectory.rods[2].x[0], 0.3 * rod.velocity.x, 1e-12);
    const Speeds speeds = speeds_along(trajectory.rods, trajectory.angles, trajectory.spacing, 1);
    EXPECT_NEAR(speeds.of_rods[2], dem::dot(rod.velocity, rod.axis), 1e-10);  // places of 20 mm over 0.1 s
    EXPECT_LE(trajectory.followed.size(), max_beads_followed);
    EXPECT_GT(trajectory.followed.size(), max_beads_followed / 2);
    const std::size_t last = trajectory.followed.back();
    EXPECT_NEAR(trajectory.beads.back().y[1] - trajectory.beads.back().y[0], 0.1 * scene.bodies.beads[last].velocity.y,
                1e-12);
}

TEST(Trajectory, refuses_unequal_times_and_other_bodies) {
    ParticleScene scene = random_particles(9, 5, 3);
    Trajectory trajectory;
    add_snapshot(trajectory, 0.0, scene.bodies);
    EXPECT_THROW(add_snapshot(trajectory, 0.0, scene.bodies), Error);
    add_snapshot(trajectory, 0.1, scene.bodies);
    EXPECT_THROW(add_snapshot(trajectory, 0.3, scene.bodies), Error);
    scene.add_bead(0.0, 0.0);
    EXPECT_THROW(add_snapshot(trajectory, 0.2, scene.bodies), Error);
    scene.bodies.beads.pop_back();
    add_snapshot(trajectory, 0.2, scene.bodies);  // as if nothing had been
    EXPECT_EQ(trajectory.angles[0].size(), 3u);
}

TEST(Histogram, is_a_density) {
    const std::vector<double> values = normal_numbers(10000, 51);
    const Histogram found = histogram(values, 20);
    double sum = 0.0;
    for (std::size_t b = 0; b < 20; ++b) sum += found.density[b] * found.width;
    EXPECT_NEAR(sum, 1.0, 1e-10);
    const Histogram alike = histogram(std::vector{2.0, 2.0}, 4);
    EXPECT_NEAR(alike.density[0] * alike.width, 1.0, 1e-15);
    EXPECT_TRUE(histogram({}, 4).density.empty());
}

}  // namespace
}  // namespace drover::measure
