// tests/calibrate/trial_set.cpp: the result does not depend on the order of trials; failed trials are replaced.
#include "calibrate/trial_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"

namespace drover::calibrate::trial_set_tests {
namespace {

Assay mean_of_one() {
    return {.name = "plain",
            .population = Population::beads,
            .quantities = {{"length", "mm", "mean"}},
            .trial = {},
            .estimator =
                [](std::span<const Trial>) {
                    return [](std::span<const double> means) -> std::vector<double> { return {means[0]}; };
                },
            .conclude = {}};
}

constexpr Goal goal{.relative_error = 0.02, .round = 8, .max_trials = 200};

/// Trial `number` of a quantity 10 +- 1.
Attempt good(std::uint64_t number) {
    Trial numbers(1);
    fill_normal({.seed = 3, .stream = Stream::test}, number, 1, numbers);
    return {.number = number, .numbers = {10.0 + numbers[0]}, .failure = {}};
}
Attempt bad(std::uint64_t number) { return {.number = number, .numbers = {}, .failure = "a sphere is lost"}; }

/// Adds the needed trials, optionally in reverse order, until the set has ended.
TrialSet carried_out(const std::function<Attempt(std::uint64_t)>& make, double max_failed, bool backwards) {
    TrialSet trial_set(mean_of_one(), goal, max_failed);
    std::uint64_t given = 0;
    while (!trial_set.ended()) {
        std::vector<std::uint64_t> numbers;
        for (; given < trial_set.needed(); ++given) numbers.push_back(given);
        EXPECT_FALSE(numbers.empty());
        if (numbers.empty()) break;
        if (backwards) std::reverse(numbers.begin(), numbers.end());
        for (const std::uint64_t number : numbers) trial_set.add(make(number));
    }
    return trial_set;
}

TEST(TrialSet, gives_the_result_of_the_stopping_rule_in_any_order_of_trials) {
    const TrialSet forwards = carried_out(good, 0.0, false), backwards = carried_out(good, 0.0, true);
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < forwards.needed(); ++t) trials.push_back(good(t).numbers);
    const StoppingDecision decision = judge(mean_of_one(), trials, goal);
    ASSERT_TRUE(decision.measurement && forwards.measurement() && backwards.measurement());
    EXPECT_TRUE(decision.measurement->reached);
    for (const TrialSet* one : {&forwards, &backwards}) {
        EXPECT_EQ(one->measurement()->trials, decision.measurement->trials);
        EXPECT_EQ(one->needed(), trials.size());
        EXPECT_EQ(one->measurement()->estimates[0].mean, decision.measurement->estimates[0].mean);
        EXPECT_EQ(one->measurement()->estimates[0].error, decision.measurement->estimates[0].error);
    }
}

TEST(TrialSet, ignores_trials_that_are_not_needed_and_duplicates) {
    const TrialSet plain = carried_out(good, 0.0, false);
    TrialSet more(mean_of_one(), goal, 0.0);
    for (std::uint64_t t = 0; t < 300; ++t) more.add(good(299 - t)), more.add(bad(299 - t));
    ASSERT_TRUE(more.measurement());
    EXPECT_EQ(more.measurement()->trials, plain.measurement()->trials);
    EXPECT_EQ(more.measurement()->estimates[0].mean, plain.measurement()->estimates[0].mean);
}

TEST(TrialSet, replaces_failed_trials) {
    const auto some = [](std::uint64_t t) { return t % 20 == 7 ? bad(t) : good(t); };
    const TrialSet forwards = carried_out(some, 0.1, false), backwards = carried_out(some, 0.1, true);
    ASSERT_TRUE(forwards.measurement() && backwards.measurement());
    EXPECT_GT(forwards.failed(), 0u);
    EXPECT_EQ(forwards.first_failure(), "a sphere is lost");
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < forwards.needed(); ++t)
        if (t % 20 != 7) trials.push_back(good(t).numbers);
    EXPECT_EQ(forwards.measurement()->estimates[0].mean,
              judge(mean_of_one(), trials, goal).measurement->estimates[0].mean);
    EXPECT_EQ(forwards.measurement()->trials + forwards.failed(), forwards.needed());
    EXPECT_EQ(backwards.needed(), forwards.needed());
    EXPECT_EQ(backwards.measurement()->estimates[0].error, forwards.measurement()->estimates[0].error);
}

TEST(TrialSet, fails_early_if_most_trials_fail_and_at_the_end_if_too_many_do) {
    const TrialSet all = carried_out(bad, 0.1, false);
    EXPECT_EQ(all.needed(), 16u);
    EXPECT_FALSE(all.measurement());
    EXPECT_EQ(all.failure_reason(), "plain: 16 of 16 trials failed; expected at most 10 %: a sphere is lost");
    const TrialSet seventh = carried_out([](std::uint64_t t) { return t % 7 == 0 ? bad(t) : good(t); }, 0.1, true);
    EXPECT_FALSE(seventh.measurement());
    EXPECT_NE(seventh.failure_reason().value_or("").find("expected at most 10 %"), std::string::npos);
}

TEST(TrialSet, keeps_its_result_if_the_target_error_is_not_reached) {
    TrialSet trial_set(mean_of_one(), {.relative_error = 1e-3, .round = 8, .max_trials = 20}, 0.0);
    for (std::uint64_t t = 0; t < 16; ++t) trial_set.add(good(t));
    ASSERT_TRUE(trial_set.measurement());
    EXPECT_FALSE(trial_set.measurement()->reached);
    EXPECT_NE(trial_set.measurement()->unmet_target.find("trials are needed"), std::string::npos);
}

TEST(TrialSet, reports_completed_rounds_before_the_end) {
    TrialSet trial_set(mean_of_one(), {.relative_error = 1e-3, .round = 8, .max_trials = 200}, 0.0);
    for (std::uint64_t t = 0; t < 15; ++t) trial_set.add(good(t));
    EXPECT_FALSE(trial_set.so_far());
    for (std::uint64_t t = 15; t < 30; ++t) trial_set.add(good(t));
    ASSERT_TRUE(trial_set.so_far());
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < 24; ++t) trials.push_back(good(t).numbers);
    const std::vector<measure::Estimate> expected = measurement_of(mean_of_one(), trials).estimates;
    EXPECT_EQ(trial_set.so_far()->trials, 24u);
    EXPECT_EQ(trial_set.so_far()->estimates[0].mean, expected[0].mean);
    EXPECT_EQ(trial_set.so_far()->estimates[0].error, expected[0].error);
    for (std::uint64_t t = 30; t < 200; ++t) trial_set.add(good(t));
    EXPECT_TRUE(trial_set.ended() && !trial_set.so_far());
}

TEST(TrialSet, rejects_invalid_goals) {
    EXPECT_THROW(TrialSet(mean_of_one(), {.relative_error = 0.0}, 0.0), Error);
    EXPECT_THROW(TrialSet(mean_of_one(), goal, 1.0), Error);
}

}  // namespace
}  // namespace drover::calibrate::trial_set_tests
