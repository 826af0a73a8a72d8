// tests/jobs/target_plan.cpp: which trials run for wanted numbers, in a world whose trials are normal numbers.
#include "jobs/calibration/target_plan.hpp"

#include <gtest/gtest.h>

#include "base/refusal.hpp"
#include "jobs/normal_world.hpp"

namespace drover::jobs::target_plan_tests {
namespace {
using calibrate::TrialSet;

struct Ended {
    std::vector<TrialSet> sets;
    std::vector<TargetProgress> values;
};

/// Runs the trials that the plan asks for.
Ended carried_out(const CalibrationLayout& layout, const char* target, const TargetLimits& limits, std::uint64_t seed,
                  const NormalScatter& scatter = {}) {
    TargetPlan plan(layout, {parse_accuracy_target(target)}, limits);
    Ended ended;
    for (const CalibrationUnit& unit : layout.units)
        ended.sets.emplace_back(layout.assays[unit.assay], TrialSet::no_goal(), 0.1);
    for (bool goes_on = true; goes_on;) {
        std::vector<UnitProgress> progress;
        for (const TrialSet& set : ended.sets) progress.push_back({.trials = &set, .given = set.count()});
        const std::vector<std::uint64_t> needed = plan.next(progress);
        goes_on = false;
        for (std::size_t u = 0; u < ended.sets.size(); ++u)
            for (; ended.sets[u].count() < needed[u]; goes_on = true)
                ended.sets[u].add(trial_of(layout, u, ended.sets[u].count(), seed, scatter));
    }
    ended.values = plan.values();
    return ended;
}

TEST(WantPlanLong, gives_trials_to_what_makes_the_error_and_reaches_it) {
    const CalibrationLayout layout = normal_layout();
    const Ended ended = carried_out(layout, "onset=3%", {.max_trials = 2000}, 1);
    ASSERT_EQ(ended.values.size(), 1u);
    EXPECT_TRUE(ended.values[0].reached);
    EXPECT_LE(ended.values[0].cautious_error, ended.values[0].result.allowed);
    EXPECT_NEAR(ended.values[0].result.value, 0.45, 4.0 * ended.values[0].result.error);
    for (std::size_t u = 0; u < layout.units.size(); ++u) {
        const CalibrationUnit& unit = layout.units[u];
        const double bead = layout.axes.bead_fractions[unit.bead];
        const std::size_t trials = ended.sets[u].count();
        const bool is_certain = unit.assay == 2, is_far = std::abs(bead - 0.45) > 0.2;
        if (is_certain || is_far) {
            EXPECT_LE(trials, 60u) << unit.name;
        } else if (std::abs(bead - 0.45) < 0.06) {
            EXPECT_GE(trials, 120u) << unit.name;
        }
    }
}

TEST(WantPlanSlow, covers_the_true_onset_as_often_as_it_claims) {
    const CalibrationLayout layout = normal_layout();
    int covered = 0;
    constexpr int repeats = 100;
    for (std::uint64_t seed = 0; seed < repeats; ++seed) {
        const TargetProgress onset = carried_out(layout, "onset=4%", {.max_trials = 2000}, seed).values[0];
        if (std::abs(onset.result.value - 0.45) <= onset.cautious_error) ++covered;
    }
    // 68 % with a standard deviation of 4.7 %; a stop at the first error that is small by chance gives 40 %.
    EXPECT_GE(covered, 55);
    EXPECT_LE(covered, 85);
}

TEST(WantPlanLong, says_why_an_error_was_not_reached) {
    const CalibrationLayout layout = normal_layout();
    const Ended limited = carried_out(layout, "onset=0.1%", {.max_trials = 20}, 1);
    EXPECT_FALSE(limited.values[0].reached);
    EXPECT_NE(limited.values[0].note.find("calibrate.max_trials = 20"), std::string::npos) << limited.values[0].note;
    const Ended poor = carried_out(layout, "onset=0.1%", {.max_trials = 2000, .budget = 800.0}, 1);
    EXPECT_NE(poor.values[0].note.find("the budget is spent"), std::string::npos) << poor.values[0].note;
    double seconds = 0.0;
    for (const TrialSet& set : poor.sets) seconds += set.core_seconds();
    EXPECT_GE(seconds, 790.0);
    EXPECT_LE(seconds, 815.0);  // one trial more
}

TEST(TargetPlan, of_coefficients_needs_their_points_alone) {
    const CalibrationLayout layout = normal_layout();
    const Ended ended = carried_out(layout, "weathercock(0.25<Phi_b<0.45)=5%", {.max_trials = 2000}, 1);
    ASSERT_EQ(ended.values.size(), 2u);
    for (std::size_t u = 0; u < layout.units.size(); ++u) {
        const CalibrationUnit& unit = layout.units[u];
        const bool is_wanted = unit.assay == 1 && (unit.bead == 1 || unit.bead == 2);
        // (0.3/0.05)^2 = 36 trials, and a quarter more for what these leave uncertain.
        const auto trials = static_cast<double>(ended.sets[u].count());
        EXPECT_NEAR(trials, is_wanted ? 45.0 : 0.0, is_wanted ? 20.0 : 0.0) << unit.name;
    }
}

TEST(TargetPlan, goes_on_where_a_divisor_is_within_its_error_of_zero) {
    // a of four trials is known to a half, and the alignment divides by it.
    const CalibrationLayout layout = normal_layout();
    const Ended ended = carried_out(layout, "alignment(0.35<Phi_b<0.45)=40%", {.max_trials = 2000}, 3, {.rods = 1.0});
    ASSERT_EQ(ended.values.size(), 1u);
    EXPECT_TRUE(ended.values[0].reached) << ended.values[0].note;
    EXPECT_NEAR(ended.values[0].result.value, 2.0 * 0.1 * 2.6 / 0.28, 4.0 * ended.values[0].result.error);
}

TEST(TargetPlan, rejects_targets_that_the_table_cannot_answer) {
    const CalibrationLayout layout = normal_layout();
    const auto why_no_error = [&](const char* target) {
        return refusal_of([&] { TargetPlan(layout, {parse_accuracy_target(target)}, {}); });
    };
    EXPECT_NE(why_no_error("onsett=5%").find("did you mean onset?"), std::string::npos) << why_no_error("onsett=5%");
    EXPECT_NE(why_no_error("onset(q<1)=5%").find("expected Phi_b, Phi_r"), std::string::npos);
    EXPECT_NE(why_no_error("onset(Phi_r>0.2)=5%").find("no point of the table is in this range"), std::string::npos);
    EXPECT_NE(why_no_error("damping_rate=5%").find("--want damping_rate"), std::string::npos);
}

}  // namespace
}  // namespace drover::jobs::target_plan_tests
