// tests/calibrate/assay.cpp: seeds, errors over trials, the rule that stops, and what is said where it does not.
#include "drover/calibrate/assay.hpp"

#include <gtest/gtest.h>

#include <set>

#include "base/refusal.hpp"
#include "calibrate/synthetic.hpp"
#include "drover/base/error.hpp"
#include "drover/calibrate/catalogue.hpp"

namespace drover::calibrate {
namespace {

/// An assay of one number: its mean, `value`, with deviation 1 from trial to trial.
Assay plain(double value) {
    return {.name = "plain",
            .quantities = {{"length", "mm", "mean"}, {"square", "mm^2", "square of the mean", false}},
            .trial =
                [value](const SystemFactory&, const dem::Setup&, std::uint64_t seed) {
                    Trial trial(1);
                    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, trial);
                    trial[0] += value;
                    return trial;
                },
            .estimator =
                [](std::span<const Trial>) {
                    return [](std::span<const double> means) -> std::vector<double> {
                        return {means[0], means[0] * means[0]};
                    };
                },
            .conclude = {}};
}

std::vector<Trial> trials_of(const Assay& assay, std::size_t count) {
    std::vector<Trial> trials;
    for (std::size_t t = 0; t < count; ++t) trials.push_back(run_trial(assay, {}, {.setup = {}, .seed = 5}, t));
    return trials;
}

TEST(AssayRule, gives_every_trial_of_every_assay_a_seed_of_its_own) {
    std::set<std::uint64_t> seeds;
    for (const std::uint64_t seed : {1u, 2u})
        for (const char* assay : {"drag", "damping"})
            for (std::uint64_t trial = 0; trial < 100; ++trial) seeds.insert(trial_seed(seed, assay, trial));
    EXPECT_EQ(seeds.size(), 400u);
    EXPECT_EQ(trial_seed(1, "drag", 7), trial_seed(1, "drag", 7));
}

TEST(AssayRule, has_the_error_of_a_mean_and_takes_off_the_bias_of_a_square) {
    const Assay assay = plain(10.0);
    const std::vector<Trial> trials = trials_of(assay, 40);
    double mean = 0.0, squares = 0.0;
    for (const Trial& trial : trials) mean += trial[0] / 40.0;
    for (const Trial& trial : trials) squares += (trial[0] - mean) * (trial[0] - mean);
    const double error = std::sqrt(squares / 39.0 / 40.0);
    const auto found = estimate(assay, trials);
    // 400 resamples know a spread to 1/sqrt(800) of it, and a mean to 1/20 of the spread.
    EXPECT_NEAR(found[0].mean, mean, 4.0 * error / 20.0);
    EXPECT_NEAR(found[0].error.value_or(0.0), error, 4.0 * error / std::sqrt(800.0));
    EXPECT_NEAR(found[1].mean, mean * mean - error * error, 4.0 * 2.0 * mean * error / 20.0);
    EXPECT_NEAR(found[1].error.value_or(0.0), 2.0 * mean * error, 0.2 * 2.0 * mean * error);
    EXPECT_EQ(found[0].samples, 40u);
}

TEST(AssayRule, stops_after_the_first_whole_round_that_is_good_enough_whatever_comes_after) {
    // An error of 1/sqrt(n) against 10: 2 % from n = 25 on.
    const Assay assay = plain(10.0);
    const Goal goal{.relative_error = 0.02, .round = 4};
    std::vector<Trial> trials;
    StoppingDecision judgement = judge(assay, trials, goal);
    EXPECT_EQ(judgement.begin, 0u);
    EXPECT_EQ(judgement.end, 8u);
    while (!judgement.measurement) {
        EXPECT_EQ(judgement.end % 4, 0u);
        trials = trials_of(assay, judgement.end);
        judgement = judge(assay, trials, goal);
    }
    EXPECT_TRUE(judgement.measurement->reached);
    EXPECT_EQ(judgement.measurement->trials, trials.size());
    EXPECT_GT(trials.size(), 11u);
    EXPECT_LT(trials.size(), 45u);
    const StoppingDecision more = judge(assay, trials_of(assay, trials.size() + 13), goal);
    ASSERT_TRUE(more.measurement);
    EXPECT_EQ(more.measurement->trials, judgement.measurement->trials);
    EXPECT_EQ(more.measurement->estimates[0].mean, judgement.measurement->estimates[0].mean);
    EXPECT_EQ(more.measurement->estimates[0].error, judgement.measurement->estimates[0].error);
    const Measurement whole = carry_out(assay, {}, {.setup = {}, .seed = 5}, goal);
    EXPECT_EQ(whole.trials, judgement.measurement->trials);
    EXPECT_EQ(whole.estimates[0].mean, judgement.measurement->estimates[0].mean);
}

TEST(AssayRule, that_cannot_reach_its_error_says_so_in_a_sentence) {
    const Measurement far =
        carry_out(plain(10.0), {}, {.setup = {}, .seed = 5}, {.relative_error = 0.001, .max_trials = 40});
    EXPECT_FALSE(far.reached);
    EXPECT_EQ(far.trials, 32u);  // whole rounds
    const double error = *far.estimates[0].error / far.estimates[0].mean;
    EXPECT_EQ(far.unmet_target,
              text("plain: length is known to {:.3g} % after 32 trials; 0.1 % was asked: about {:.0f} trials would do",
                   100.0 * error, std::ceil(32.0 * std::pow(error / 0.001, 2))));
    const Measurement none = carry_out(plain(0.0), {}, {.setup = {}, .seed = 5}, {.max_trials = 40});
    EXPECT_NE(none.unmet_target.find("cannot be told from 0"), std::string::npos) << none.unmet_target;
}

TEST(AssayRule, refuses_goals_and_trials_that_cannot_be) {
    const Assay assay = plain(1.0);
    EXPECT_THROW(judge(assay, {}, {.relative_error = 0.0}), Error);
    EXPECT_THROW(judge(assay, {}, {.round = 0}), Error);
    EXPECT_THROW(judge(assay, {}, {.round = 3}), Error);
    EXPECT_THROW(judge(assay, {}, {.max_trials = 20}), Error);
    EXPECT_THROW(estimate(assay, std::vector<Trial>{{1.0}, {1.0, 2.0}}), Error);
    Conditions round = stand_in(4);
    round.setup.cell.shape = "circle";
    EXPECT_EQ(refusal_of([&] { run_trial(assay, {}, round, 0); }),
              "plain: a cell of shape \"circle\"; expected \"periodic\"");
    const auto refused = [&](const Assay& of, int rods, int beads) {
        Conditions conditions = stand_in(rods);
        conditions.setup.beads.count = beads;
        return refusal_of([&] { run_trial(of, synthetic_maker({}), conditions, 0); });
    };
    EXPECT_EQ(refused(relaxation(), 0, 900).substr(0, 32), "relaxation: a setup without rods");
    EXPECT_EQ(refused(damping(), 4, 0).substr(0, 30), "damping: a setup without beads");
}

TEST(AssayRule, refuses_forces_that_stand_twice_and_windows_that_are_too_few) {
    // Quantities are named by them: two of one name make no table.
    EXPECT_NE(refusal_of([] {
                  drag({.torques = {200.0, 500.0, 500.0}});
              }).find("each more than the one before"),
              std::string::npos);
    EXPECT_NE(refusal_of([] {
                  weathercock({.speeds = {1.0, 2.0, 2.0}});
              }).find("each more than the one before"),
              std::string::npos);
    EXPECT_NE(refusal_of([] {
                  shear({.waves = {1.0, 3.0, 3.0}});
              }).find("each more than the one before"),
              std::string::npos);
    EXPECT_NE(refusal_of([] {
                  drag({.torques = {200.0, 500.0}, .windows = 1});
              }).find("expected 3 windows or more"),
              std::string::npos);
}

TEST(AssayRule, every_assay_has_a_name_a_trial_and_quantities_with_units_and_formulas) {
    const std::vector<Assay> assays = make_assays();
    std::set<std::string> names;
    for (const Assay& assay : assays) {
        names.insert(assay.name);
        EXPECT_TRUE(assay.trial && assay.estimator) << assay.name;
        EXPECT_TRUE(assay.quantities.front().wanted) << assay.name;
        for (const Quantity& quantity : assay.quantities)
            EXPECT_FALSE(quantity.name.empty() || quantity.unit.empty() || quantity.formula.empty()) << assay.name;
        EXPECT_EQ(&find_assay(assays, assay.name), &assay);
    }
    EXPECT_EQ(names.size(), assays.size()) << "two assays share a name";
    EXPECT_EQ(refusal_of([&] { find_assay(std::span(assays).first(2), "drags"); }),
              "there is no assay \"drags\"; expected one of relaxation, weathercock");
    EXPECT_THROW(make_assays({.drag = {.torques = {5.0, 1.0}}}), Error);
    EXPECT_THROW(make_assays({.damping = {.speed_flock = 0.5}}), Error);
    EXPECT_THROW(make_assays({.relaxation = {.max_lag = 100.0}}), Error);
}

TEST(AssayRule, an_estimate_that_most_resamples_do_not_give_has_no_error) {
    Assay assay = plain(0.1);  // the root of a mean whose error is as large
    assay.estimator = [](std::span<const Trial>) {
        return [](std::span<const double> means) -> std::vector<double> { return {std::sqrt(means[0]), 0.0}; };
    };
    const auto found = estimate(assay, trials_of(assay, 32));
    EXPECT_FALSE(found[0].error);
    EXPECT_NE(found[0].refusal.find("resamples"), std::string::npos);
}

Measurement measured(const Assay& assay, const Truth& truth, int rods) {
    return carry_out(assay, synthetic_maker(truth), stand_in(rods), {.max_trials = 64});
}

TEST(AssayVerdict, tells_coulomb_friction_from_linear_damping) {
    const Assay assay = damping({.warm_up = 0.0, .hold = 0.01, .time = 1.0, .frame = 0.005});
    const Truth linear{.damping = 5.0, .coulomb = 0.0, .agitation = 0.1, .step = 0.005};
    Truth dry = linear;
    dry.damping = 1.0, dry.coulomb = 30.0;
    EXPECT_EQ(measured(assay, linear, 0).diagnosis.substr(0, 44), "the damping is linear as far as can be told:");
    const Measurement found = measured(assay, dry, 0);
    EXPECT_EQ(found.diagnosis.substr(0, 28), "the damping is Coulomb-like:");
    // The table: g + c/v, less and less from slow to fast.
    EXPECT_GT(found.estimates[6].mean, 1.5 * found.estimates[5].mean);
    EXPECT_GT(found.estimates[5].mean, 1.5 * found.estimates[4].mean);
}

TEST(AssayVerdict, tells_a_bent_curve_of_drag_from_a_straight_one) {
    const Assay assay = drag({.torques = {100.0, 250.0, 600.0, 2000.0}, .time = 1.6, .frame = 0.05});
    const Truth straight{.damping = 2.0, .drag = 3.0, .agitation = 0.1, .step = 0.025};
    Truth bent = straight;
    bent.drag_cubic = -1.5;
    EXPECT_EQ(measured(assay, straight, 8).diagnosis.substr(0, 36), "the flow is linear in the order, to ");
    EXPECT_EQ(measured(assay, bent, 8).diagnosis.substr(0, 38), "the flow is not linear in the order: a");
}

TEST(AssayVerdict, has_nothing_to_say_of_a_line_through_two_rates) {
    const Assay assay = shear({.waves = {1.0, 2.0}});
    const Measurement found = carry_out(assay, synthetic_maker({}), stand_in(0), {.round = 8, .max_trials = 16});
    EXPECT_TRUE(std::isnan(found.estimates[2].mean));
    EXPECT_EQ(found.diagnosis, "whether the rates lie on a line in q^2 is not known");
    EXPECT_TRUE(found.estimates[0].error.has_value());
}

TEST(AssayVerdict, refuses_a_modulus_that_fluctuations_hide) {
    const Assay assay = stiffness({.pushes = {1e-3, 2e-3}, .warm_up = 0.0, .time = 0.5});
    const Measurement found = measured(assay, {}, 0);
    EXPECT_FALSE(found.reached);
    EXPECT_FALSE(found.estimates[0].error);
    EXPECT_TRUE(std::isnan(found.estimates[0].mean));
    EXPECT_NE(found.unmet_target.find("the density does not answer to the force"), std::string::npos)
        << found.unmet_target;
}

TEST(AssayVerdict, a_flow_that_does_not_turn_rods_is_told_as_none) {
    const Measurement found = measured(weathercock({.warm_up = 0.0}), {.turning = 0.0, .step = 0.05}, 4);
    EXPECT_FALSE(found.reached);
    EXPECT_LT(std::abs(found.estimates[0].mean), 3.0 * *found.estimates[0].error);
    EXPECT_EQ(found.unmet_target.substr(0, 33), "weathercock: weathercock_single =");
}

TEST(AssayVerdict, tells_where_loss_of_direction_becomes_exponential_and_that_it_never_does) {
    const Assay assay = relaxation({.warm_up = 0.0, .time = 4.0, .max_lag = 2.0});
    const auto goal = Goal{.round = 64, .max_trials = 128};
    const Measurement early =
        carry_out(assay, synthetic_maker({.memory = 0.0, .jitter = 0.1, .step = 0.025}), stand_in(8), goal);
    const Measurement late =
        carry_out(assay, synthetic_maker({.memory = 0.05, .jitter = 0.0, .step = 0.025}), stand_in(8), goal);
    EXPECT_LE(early.estimates[2].mean, 0.1);
    EXPECT_NEAR(early.estimates[1].mean, 0.01, 0.003);  // the square of the jitter
    EXPECT_GE(late.estimates[2].mean, 0.1);             // twice the memory
    const Measurement never = carry_out(assay, synthetic_maker({.memory = 3.0, .step = 0.025}), stand_in(8), goal);
    EXPECT_TRUE(std::isnan(never.estimates[2].mean));
    EXPECT_EQ(never.diagnosis.substr(0, 22), "no exponential regime:");
}

}  // namespace
}  // namespace drover::calibrate
