// tests/calibrate/trial_set.cpp: trials in any order, some of which fail, come to the same end.
#include "drover/calibrate/trial_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"

namespace drover::calibrate {
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

/// Gives what is wanted, the last first, until it has ended.
TrialSet carried_out(const std::function<Attempt(std::uint64_t)>& make, double max_failed, bool backwards) {
    TrialSet trial_set(mean_of_one(), goal, max_failed);
    std::uint64_t given = 0;
    while (!trial_set.ended()) {
        std::vector<std::uint64_t> numbers;
        for (; given < trial_set.wanted(); ++given) numbers.push_back(given);
        EXPECT_FALSE(numbers.empty());
        if (numbers.empty()) break;
        if (backwards) std::reverse(numbers.begin(), numbers.end());
        for (const std::uint64_t number : numbers) trial_set.add(make(number));
    }
    return trial_set;
}

TEST(TrialSet, ends_as_the_rule_does_on_the_trials_in_their_order) {
    const TrialSet forwards = carried_out(good, 0.0, false), backwards = carried_out(good, 0.0, true);
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < forwards.wanted(); ++t) trials.push_back(good(t).numbers);
    const StoppingDecision judgement = judge(mean_of_one(), trials, goal);
    ASSERT_TRUE(judgement.measurement && forwards.measurement() && backwards.measurement());
    EXPECT_TRUE(judgement.measurement->reached);
    for (const TrialSet* one : {&forwards, &backwards}) {
        EXPECT_EQ(one->measurement()->trials, judgement.measurement->trials);
        EXPECT_EQ(one->wanted(), trials.size());
        EXPECT_EQ(one->measurement()->estimates[0].mean, judgement.measurement->estimates[0].mean);
        EXPECT_EQ(one->measurement()->estimates[0].error, judgement.measurement->estimates[0].error);
    }
}

TEST(TrialSet, is_not_changed_by_trials_that_nobody_wanted_or_that_come_twice) {
    const TrialSet plain = carried_out(good, 0.0, false);
    TrialSet more(mean_of_one(), goal, 0.0);
    for (std::uint64_t t = 0; t < 300; ++t) more.add(good(299 - t)), more.add(bad(299 - t));
    ASSERT_TRUE(more.measurement());
    EXPECT_EQ(more.measurement()->trials, plain.measurement()->trials);
    EXPECT_EQ(more.measurement()->estimates[0].mean, plain.measurement()->estimates[0].mean);
}

TEST(TrialSet, goes_on_with_others_where_a_few_trials_fail) {
    const auto some = [](std::uint64_t t) { return t % 20 == 7 ? bad(t) : good(t); };
    const TrialSet forwards = carried_out(some, 0.1, false), backwards = carried_out(some, 0.1, true);
    ASSERT_TRUE(forwards.measurement() && backwards.measurement());
    EXPECT_GT(forwards.failed(), 0u);
    EXPECT_EQ(forwards.failure(), "a sphere is lost");
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < forwards.wanted(); ++t)
        if (t % 20 != 7) trials.push_back(good(t).numbers);
    EXPECT_EQ(forwards.measurement()->estimates[0].mean,
              judge(mean_of_one(), trials, goal).measurement->estimates[0].mean);
    EXPECT_EQ(forwards.measurement()->trials + forwards.failed(), forwards.wanted());
    EXPECT_EQ(backwards.wanted(), forwards.wanted());
    EXPECT_EQ(backwards.measurement()->estimates[0].error, forwards.measurement()->estimates[0].error);
}

TEST(TrialSet, is_refused_at_once_where_most_trials_fail_and_in_the_end_where_too_many_do) {
    const TrialSet all = carried_out(bad, 0.1, false);
    EXPECT_EQ(all.wanted(), 16u);
    EXPECT_FALSE(all.measurement());
    EXPECT_EQ(all.refusal(), "plain: 16 of 16 trials failed; expected at most 10 %: a sphere is lost");
    const TrialSet seventh = carried_out([](std::uint64_t t) { return t % 7 == 0 ? bad(t) : good(t); }, 0.1, true);
    EXPECT_FALSE(seventh.measurement());
    EXPECT_NE(seventh.refusal().find("expected at most 10 %"), std::string::npos);
}

TEST(TrialSet, keeps_what_it_has_where_the_error_asked_is_out_of_reach) {
    TrialSet trial_set(mean_of_one(), {.relative_error = 1e-3, .round = 8, .max_trials = 20}, 0.0);
    for (std::uint64_t t = 0; t < 16; ++t) trial_set.add(good(t));
    ASSERT_TRUE(trial_set.measurement());
    EXPECT_FALSE(trial_set.measurement()->reached);
    EXPECT_NE(trial_set.measurement()->unmet_target.find("trials would do"), std::string::npos);
}

TEST(TrialSet, tells_what_whole_rounds_have_so_far) {
    TrialSet trial_set(mean_of_one(), {.relative_error = 1e-3, .round = 8, .max_trials = 200}, 0.0);
    for (std::uint64_t t = 0; t < 15; ++t) trial_set.add(good(t));
    EXPECT_FALSE(trial_set.so_far());
    for (std::uint64_t t = 15; t < 30; ++t) trial_set.add(good(t));
    ASSERT_TRUE(trial_set.so_far());
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < 24; ++t) trials.push_back(good(t).numbers);
    const std::vector<measure::Estimate> expected = estimate(mean_of_one(), trials);
    EXPECT_EQ(trial_set.so_far()->trials, 24u);
    EXPECT_EQ(trial_set.so_far()->estimates[0].mean, expected[0].mean);
    EXPECT_EQ(trial_set.so_far()->estimates[0].error, expected[0].error);
    for (std::uint64_t t = 30; t < 200; ++t) trial_set.add(good(t));
    EXPECT_TRUE(trial_set.ended() && !trial_set.so_far());
}

TEST(TrialSet, refuses_a_goal_that_cannot_be) {
    EXPECT_THROW(TrialSet(mean_of_one(), {.relative_error = 0.0}, 0.0), Error);
    EXPECT_THROW(TrialSet(mean_of_one(), goal, 1.0), Error);
}

}  // namespace
}  // namespace drover::calibrate
