// tests/measure/replicates.cpp: errors over seeds cover the truth as often as they claim, whatever the runs claim.
#include "measure/replicates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace drover::measure::replicates_tests {
namespace {

constexpr double truth = 0.7;

/// What the runs of a synthetic set say of their own errors.
struct Own {
    bool is_given = true;
    double factor = 1.0;      ///< own error over the true one
    std::size_t blocks = 16;  ///< from which it is estimated
};

std::vector<Estimate> runs(std::size_t count, const Own& own, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    std::vector<Estimate> result;
    for (std::size_t i = 0; i < count; ++i) {
        Estimate run{.mean = truth + 0.1 * normal(random)};
        if (own.is_given) {
            std::chi_squared_distribution<double> squares(static_cast<double>(own.blocks - 1));
            run.error = 0.1 * own.factor * std::sqrt(squares(random) / static_cast<double>(own.blocks - 1));
            run.blocks = own.blocks;
        } else {
            run.why_no_error = "too short";
        }
        result.push_back(run);
    }
    return result;
}

double coverage(std::size_t seeds, const Own& own) {
    constexpr int sets = 10000;
    std::mt19937_64 random(seeds);
    int covered = 0;
    for (int i = 0; i < sets; ++i) {
        const Estimate mean = combine(runs(seeds, own, random)).mean;
        covered += std::abs(mean.mean - truth) < mean.error.value() ? 1 : 0;
    }
    return static_cast<double>(covered) / sets;
}

// 10,000 sets give the coverage to 0.0047: 0.66 and 0.70 are 4.9 and 3.7 of these from 0.683.  The standard error
// without Student's t covers 0.577 with three seeds, and 0.66 is passed with eleven only.
TEST(Replicates, errors_over_seeds_cover_the_truth_in_two_cases_of_three_with_own_errors_and_without) {
    for (std::size_t seeds = 3; seeds <= 32; ++seeds)
        for (const bool is_given : {true, false}) {
            const double found = coverage(seeds, {.is_given = is_given});
            EXPECT_GT(found, 0.66) << seeds << " seeds, own errors: " << is_given;
            EXPECT_LT(found, is_given && seeds < 8 ? 0.82 : 0.70) << seeds << " seeds, own errors: " << is_given;
        }
}

TEST(Replicates, few_seeds_that_agree_by_chance_have_the_error_of_their_runs) {
    const std::vector<Estimate> pair{{.mean = 1.0, .error = 0.1, .blocks = 9},
                                     {.mean = 1.0001, .error = 0.1, .blocks = 9}};
    EXPECT_NEAR(*combine(pair).mean.error, 0.1 / std::sqrt(2.0), 1e-12);
}

TEST(Replicates, errors_over_seeds_do_not_depend_on_own_errors_that_are_wrong) {
    for (const double factor : {0.1, 10.0}) {
        const double found = coverage(8, {.factor = factor});
        EXPECT_GT(found, 0.66) << factor;
        EXPECT_LT(found, 0.70) << factor;
    }
}

/// How often sets contradict their own errors.
double alarms(std::size_t seeds, const Own& own) {
    constexpr int sets = 10000;
    std::mt19937_64 random(seeds);
    int count = 0;
    for (int i = 0; i < sets; ++i) count += contradicts(combine(runs(seeds, own, random))) ? 1 : 0;
    return static_cast<double>(count) / sets;
}

// Both sides together: one set in a thousand, so 10 of 10,000, with a standard deviation of 3.2.
TEST(Replicates, right_own_errors_are_rarely_said_to_be_wrong) {
    for (const std::size_t seeds : {2u, 4u, 16u})
        for (const std::size_t blocks : {8u, 64u})
            EXPECT_LT(alarms(seeds, {.blocks = blocks}), 0.0025) << seeds << " " << blocks;
}

TEST(Replicates, own_errors_that_are_ten_times_too_small_or_too_large_are_said_to_be_wrong) {
    EXPECT_GT(alarms(6, {.factor = 0.1}), 0.99);
    EXPECT_GT(alarms(16, {.factor = 10.0}), 0.99);
}

TEST(Replicates, six_seeds_of_which_two_end_in_another_state_have_an_error_of_that_size) {
    std::vector<Estimate> seeds;
    for (const double value : {.992, .993, .095, .991, .994, .011})
        seeds.push_back({.mean = value, .why_no_error = "short"});
    const Replicates found = combine(seeds);
    EXPECT_NEAR(found.mean.mean, 0.6793, 1e-4);
    EXPECT_NEAR(found.deviation / std::sqrt(6.0), 0.198, 1e-3);
    // Student's t with 5 degrees of freedom covers 68.3 % within 1.1105: Abramowitz and Stegun (1964), table 26.10.
    EXPECT_NEAR(*found.mean.error, 1.1105 * found.deviation / std::sqrt(6.0), 1e-4);
    EXPECT_TRUE(found.mean.why_no_error.empty());
    EXPECT_FALSE(found.own_error);
    EXPECT_FALSE(contradicts(found));
}

TEST(Replicates, a_single_run_keeps_its_own_error_or_its_reason) {
    const Replicates one = combine(std::vector<Estimate>{{.mean = 1.0, .error = 0.2, .blocks = 9}});
    EXPECT_EQ(one.mean.error, 0.2);
    EXPECT_EQ(one.own_error, 0.2);
    EXPECT_TRUE(std::isnan(one.deviation));
    const Replicates none = combine(std::vector<Estimate>{{.mean = 1.0, .why_no_error = "short"}});
    EXPECT_FALSE(none.mean.error);
    EXPECT_EQ(none.mean.why_no_error, "short");
}

TEST(Replicates, a_conserved_number_has_the_error_zero_and_an_undefined_one_has_none) {
    const Replicates constant = combine(std::vector<Estimate>(4, {.mean = 3.0, .error = 0.0}));
    EXPECT_EQ(constant.mean.error, 0.0);
    EXPECT_FALSE(contradicts(constant));
    const Replicates undefined =
        combine(std::vector<Estimate>{{.mean = 1.0}, {.mean = NAN, .why_no_error = "undefined"}});
    EXPECT_FALSE(undefined.mean.error);
    EXPECT_EQ(undefined.mean.why_no_error, "undefined");
}

TEST(Replicates, directions_have_the_mean_direction_and_not_the_mean_of_their_numbers) {
    // Six directions about pi, which is -pi: their numbers have a mean near 0 and a scatter of pi.
    const std::vector<double> away{0.02, -0.04, 0.03, -0.01, 0.05, -0.03};
    std::vector<Estimate> directions, angles;
    for (const double by : away) {
        angles.push_back({.mean = by, .error = 0.03});
        directions.push_back({.mean = std::remainder(3.0 + by + 0.2, 2.0 * std::numbers::pi), .error = 0.03});
        directions.back().averaging = Averaging::direction;
    }
    const Replicates found = combine(directions), expected = combine(angles);
    EXPECT_NEAR(std::remainder(found.mean.mean - 3.2 - expected.mean.mean, 2.0 * std::numbers::pi), 0.0, 1e-14);
    EXPECT_LE(std::abs(found.mean.mean), std::numbers::pi);
    EXPECT_NEAR(*found.mean.error, *expected.mean.error, 1e-14);
    EXPECT_EQ(found.mean.averaging, Averaging::direction);
}

TEST(Replicates, directions_without_a_common_one_have_no_error) {
    std::vector<Estimate> around;
    for (int i = 0; i < 12; ++i) {
        around.push_back({.mean = std::remainder(2.0 * std::numbers::pi * i / 12.0, 2.0 * std::numbers::pi)});
        around.back().averaging = Averaging::direction;
    }
    const Replicates found = combine(around);
    EXPECT_FALSE(found.mean.error);
    EXPECT_NE(found.mean.why_no_error.find("no common direction"), std::string::npos);
    for (const std::size_t few : {2, 3}) {
        std::vector<Estimate> alike;
        for (std::size_t i = 0; i < few; ++i) {
            alike.push_back({.mean = 3.1 + 0.01 * static_cast<double>(i)});
            alike.back().averaging = Averaging::direction;
        }
        EXPECT_TRUE(combine(alike).mean.error) << few;
    }
}

}  // namespace
}  // namespace drover::measure::replicates_tests
