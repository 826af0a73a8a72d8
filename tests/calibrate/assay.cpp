// tests/calibrate/assay.cpp: seeds, errors over trials, the stopping rule and diagnoses.
#include "drover/calibrate/assay.hpp"

#include <gtest/gtest.h>

#include <set>

#include "base/refusal.hpp"
#include "calibrate/catalogue.hpp"
#include "calibrate/synthetic.hpp"
#include "drover/base/error.hpp"

namespace drover::calibrate::assay_tests {
namespace {

/// An assay of one number with mean `value` and standard deviation 1.
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

Conditions some_rods() {
    Conditions conditions{.setup = {}, .seed = 5};
    conditions.setup.rods.count = 1;
    return conditions;
}

std::vector<Trial> trials_of(const Assay& assay, std::size_t count) {
    std::vector<Trial> trials;
    for (std::size_t t = 0; t < count; ++t) trials.push_back(run_trial(assay, {}, some_rods(), t));
    return trials;
}

TEST(AssayRule, gives_every_trial_of_every_assay_its_own_seed) {
    std::set<std::uint64_t> seeds;
    for (const std::uint64_t seed : {1u, 2u})
        for (const char* assay : {"drag", "damping"})
            for (std::uint64_t trial = 0; trial < 100; ++trial) seeds.insert(trial_seed(seed, assay, trial));
    EXPECT_EQ(seeds.size(), 400u);
    EXPECT_EQ(trial_seed(1, "drag", 7), trial_seed(1, "drag", 7));
}

TEST(AssayRule, estimates_the_error_of_a_mean_and_removes_the_bias_of_a_square) {
    const Assay assay = plain(10.0);
    const std::vector<Trial> trials = trials_of(assay, 40);
    double mean = 0.0, squares = 0.0;
    for (const Trial& trial : trials) mean += trial[0] / 40.0;
    for (const Trial& trial : trials) squares += (trial[0] - mean) * (trial[0] - mean);
    const double error = std::sqrt(squares / 39.0 / 40.0);
    const auto found = measurement_of(assay, trials).estimates;
    // 400 resamples determine a spread to 1/sqrt(800) of it, and a mean to 1/20 of the spread.
    EXPECT_NEAR(found[0].mean, mean, 4.0 * error / 20.0);
    EXPECT_NEAR(found[0].error.value_or(0.0), error, 4.0 * error / std::sqrt(800.0));
    EXPECT_NEAR(found[1].mean, mean * mean - error * error, 4.0 * 2.0 * mean * error / 20.0);
    EXPECT_NEAR(found[1].error.value_or(0.0), 2.0 * mean * error, 0.2 * 2.0 * mean * error);
    EXPECT_EQ(found[0].samples, 40u);
}

TEST(AssayRule, stops_after_the_first_round_that_meets_the_goal_and_ignores_later_trials) {
    // Error 1/sqrt(n) of a mean of 10: 2 % from n = 25.
    const Assay assay = plain(10.0);
    const Goal goal{.relative_error = 0.02, .round = 4};
    std::vector<Trial> trials;
    StoppingDecision decision = judge(assay, trials, goal);
    EXPECT_EQ(decision.begin, 0u);
    EXPECT_EQ(decision.end, 8u);
    while (!decision.measurement) {
        EXPECT_EQ(decision.end % 4, 0u);
        trials = trials_of(assay, decision.end);
        decision = judge(assay, trials, goal);
    }
    EXPECT_TRUE(decision.measurement->reached);
    EXPECT_EQ(decision.measurement->trials, trials.size());
    EXPECT_GT(trials.size(), 11u);
    EXPECT_LT(trials.size(), 45u);
    const StoppingDecision more = judge(assay, trials_of(assay, trials.size() + 13), goal);
    ASSERT_TRUE(more.measurement);
    EXPECT_EQ(more.measurement->trials, decision.measurement->trials);
    EXPECT_EQ(more.measurement->estimates[0].mean, decision.measurement->estimates[0].mean);
    EXPECT_EQ(more.measurement->estimates[0].error, decision.measurement->estimates[0].error);
    const Measurement whole = carry_out(assay, {}, some_rods(), goal);
    EXPECT_EQ(whole.trials, decision.measurement->trials);
    EXPECT_EQ(whole.estimates[0].mean, decision.measurement->estimates[0].mean);
}

TEST(AssayRule, evaluates_each_round_once) {
    int evaluations = 0;
    Assay assay = plain(10.0);
    assay.estimator = [&evaluations, whole = assay.estimator](std::span<const Trial> trials) {
        ++evaluations;
        return whole(trials);
    };
    const Goal goal{.relative_error = 0.001, .round = 4, .min_rounds = 2, .max_trials = 80};  // never reached
    EXPECT_EQ(carry_out(assay, {}, some_rods(), goal).trials, 80u);
    EXPECT_EQ(evaluations, 19);  // after 8, 12, ..., 80 trials
}

TEST(AssayRule, rejects_an_assay_that_lacks_a_function_or_gives_another_number_of_estimates) {
    const Conditions conditions = some_rods();
    const std::vector<Trial> trials = trials_of(plain(1.0), 8);
    Assay none = plain(1.0);
    none.trial = nullptr;
    EXPECT_THROW(run_trial(none, {}, conditions, 0), Error);
    none.estimator = nullptr;
    EXPECT_THROW(measurement_of(none, trials), Error);
    none.estimator = [](std::span<const Trial>) { return Estimator(); };
    EXPECT_THROW(measurement_of(none, trials), Error);
    Assay other = plain(1.0);
    other.quantities.pop_back();
    EXPECT_THROW(measurement_of(other, trials), Error);
    other.quantities.clear();
    EXPECT_THROW(measurement_of(other, trials), Error);
}

TEST(AssayRule, reports_a_target_that_is_not_reached) {
    const Measurement far = carry_out(plain(10.0), {}, some_rods(), {.relative_error = 0.001, .max_trials = 40});
    EXPECT_FALSE(far.reached);
    EXPECT_EQ(far.trials, 32u);  // whole rounds
    const double error = *far.estimates[0].error / far.estimates[0].mean;
    EXPECT_EQ(far.unmet_target, text("plain: length has an error of {:.3g} % after 32 trials; the target is 0.1 %: "
                                     "about {:.0f} trials are needed",
                                     100.0 * error, std::ceil(32.0 * std::pow(error / 0.001, 2))));
    const Measurement none = carry_out(plain(0.0), {}, some_rods(), {.max_trials = 40});
    EXPECT_NE(none.unmet_target.find("not significantly different from 0"), std::string::npos) << none.unmet_target;
}

TEST(AssayRule, rejects_invalid_goals_and_trials) {
    const Assay assay = plain(1.0);
    EXPECT_THROW(judge(assay, {}, {.relative_error = 0.0}), Error);
    EXPECT_THROW(judge(assay, {}, {.round = 0}), Error);
    EXPECT_THROW(judge(assay, {}, {.round = 3}), Error);
    EXPECT_THROW(judge(assay, {}, {.max_trials = 20}), Error);
    EXPECT_THROW(measurement_of(assay, std::vector<Trial>{{1.0}, {1.0, 2.0}}), Error);
    Conditions round = synthetic_conditions(4);
    round.setup.cell.shape = dem::CellShape::circle;
    EXPECT_EQ(refusal_of([&] { run_trial(assay, {}, round, 0); }),
              "plain: the cell shape is \"circle\"; expected \"periodic\"");
    const auto message = [&](const Assay& of, int rods, int beads) {
        Conditions conditions = synthetic_conditions(rods);
        conditions.setup.beads.count = beads;
        return refusal_of([&] { run_trial(of, synthetic_factory({}), conditions, 0); });
    };
    EXPECT_EQ(message(relaxation(), 0, 900).substr(0, 33), "relaxation: the setup has no rods");
    const Assay beads = [] {
        Assay result = plain(1.0);
        result.population = Population::beads;
        return result;
    }();
    EXPECT_EQ(message(beads, 4, 0), "plain: the setup has no beads; expected beads.area_fraction or beads.count > 0");
    EXPECT_EQ(message(assay, 0, 900), "plain: the setup has no rods; expected rods.area_fraction or rods.count > 0");
    EXPECT_EQ(refusal_of([&] {
                  measurement_of(assay, std::vector<Trial>{{}, {}});
              }),
              "plain: trials of no numbers; expected one or more");
    EXPECT_EQ(message(damping(), 4, 0).substr(0, 31), "damping: the setup has no beads");
}

TEST(AssayRule, rejects_repeated_forces_and_too_few_windows) {
    // Quantities are named after the values, so values must differ.
    EXPECT_NE(refusal_of([] { drag({.torques = {200.0, 500.0, 500.0}}); }).find("> 0, ascending"), std::string::npos);
    EXPECT_NE(refusal_of([] {
                  weathercock({.speeds = {1.0, 2.0, 2.0}});
              }).find("> 0 and ascending"),
              std::string::npos);
    EXPECT_NE(refusal_of([] { shear({.waves = {1.0, 3.0, 3.0}}); }).find("> 0 and ascending"), std::string::npos);
    EXPECT_NE(refusal_of([] {
                  drag({.torques = {200.0, 500.0}, .windows = 1});
              }).find("expected at least 3 windows"),
              std::string::npos);
}

TEST(AssayCatalogue, lists_assays_with_names_trials_and_quantities_with_units_and_formulas) {
    const std::vector<Assay> assays = make_assays();
    std::set<std::string> names;
    for (const Assay& assay : assays) {
        names.insert(assay.name);
        EXPECT_TRUE(assay.trial && assay.estimator) << assay.name;
        EXPECT_TRUE(assay.quantities.front().wanted) << assay.name;
        for (const Quantity& quantity : assay.quantities)
            EXPECT_FALSE(quantity.name.empty() || quantity.unit.empty() || quantity.formula.empty()) << assay.name;
    }
    EXPECT_EQ(names.size(), assays.size()) << "two assays share a name";
    EXPECT_THROW(make_assays({.drag = {.torques = {5.0, 1.0}}}), Error);
    EXPECT_THROW(make_assays({.damping = {.speed_flock = 0.5}}), Error);
    EXPECT_THROW(make_assays({.relaxation = {.max_lag = 100.0}}), Error);
}

TEST(AssayRule, gives_no_error_if_most_resamples_have_no_value) {
    Assay assay = plain(0.1);  // the square root of a mean that is not significant
    assay.estimator = [](std::span<const Trial>) {
        return [](std::span<const double> means) -> std::vector<double> { return {std::sqrt(means[0]), 0.0}; };
    };
    const auto found = measurement_of(assay, trials_of(assay, 32)).estimates;
    EXPECT_FALSE(found[0].error);
    EXPECT_NE(found[0].why_no_error.find("resamples"), std::string::npos);
}

Measurement measured(const Assay& assay, const Truth& truth, int rods) {
    return carry_out(assay, synthetic_factory(truth), synthetic_conditions(rods), {.max_trials = 64});
}

TEST(AssayDiagnosis, distinguishes_coulomb_friction_from_linear_damping) {
    const Assay assay = damping({.warm_up = 0.0, .hold = 0.01, .time = 1.0, .frame = 0.005});
    const Truth linear{.damping = 5.0, .coulomb = 0.0, .agitation = 0.1, .step = 0.005};
    Truth dry = linear;
    dry.damping = 1.0, dry.coulomb = 30.0;
    EXPECT_EQ(measured(assay, linear, 0).diagnosis.substr(0, 39), "the damping is linear within its error:");
    const Measurement found = measured(assay, dry, 0);
    EXPECT_EQ(found.diagnosis.substr(0, 28), "the damping is Coulomb-like:");
    // g + c/v decreases with speed.
    EXPECT_GT(found.estimates[6].mean, 1.5 * found.estimates[5].mean);
    EXPECT_GT(found.estimates[5].mean, 1.5 * found.estimates[4].mean);
}

TEST(AssayDiagnosis, distinguishes_a_curved_from_a_linear_drag_law) {
    const Assay assay = drag({.torques = {100.0, 250.0, 600.0, 2000.0}, .time = 1.6, .frame = 0.05});
    const Truth straight{.damping = 2.0, .drag = 3.0, .agitation = 0.1, .step = 0.025};
    Truth bent = straight;
    bent.drag_cubic = -1.5;
    EXPECT_EQ(measured(assay, straight, 8).diagnosis.substr(0, 36), "the flow is linear in the order, to ");
    EXPECT_EQ(measured(assay, bent, 8).diagnosis.substr(0, 38), "the flow is not linear in the order: a");
}

TEST(AssayDiagnosis, makes_no_statement_on_linearity_from_two_rates) {
    const Assay assay = shear({.waves = {1.0, 2.0}});
    const Measurement found =
        carry_out(assay, synthetic_factory({}), synthetic_conditions(0), {.round = 8, .max_trials = 16});
    EXPECT_TRUE(std::isnan(found.estimates[2].mean));
    EXPECT_EQ(found.diagnosis, "linearity of the rates in q^2 is not known");
    EXPECT_TRUE(found.estimates[0].error.has_value());
}

TEST(AssayDiagnosis, gives_no_stiffness_if_the_response_is_not_significant) {
    const Assay assay = stiffness({.pushes = {1e-3, 2e-3}, .warm_up = 0.0, .time = 0.5});
    const Measurement found = measured(assay, {}, 0);
    EXPECT_FALSE(found.reached);
    EXPECT_FALSE(found.estimates[0].error);
    EXPECT_TRUE(std::isnan(found.estimates[0].mean));
    EXPECT_NE(found.unmet_target.find("the density response does not exceed its fluctuations"), std::string::npos)
        << found.unmet_target;
}

TEST(AssayDiagnosis, finds_no_rotation_in_a_flow_that_does_not_turn_rods) {
    const Measurement found = measured(weathercock({.warm_up = 0.0}), {.turning = 0.0, .step = 0.05}, 4);
    EXPECT_FALSE(found.reached);
    EXPECT_LT(std::abs(found.estimates[0].mean), 3.0 * *found.estimates[0].error);
    EXPECT_EQ(found.unmet_target.substr(0, 33), "weathercock: weathercock_single =");
}

TEST(AssayDiagnosis, finds_where_the_decay_becomes_exponential_or_that_it_does_not) {
    const Assay assay = relaxation({.warm_up = 0.0, .time = 4.0, .max_lag = 2.0});
    const auto goal = Goal{.round = 64, .max_trials = 128};
    const Measurement early = carry_out(assay, synthetic_factory({.memory = 0.0, .jitter = 0.1, .step = 0.025}),
                                        synthetic_conditions(8), goal);
    const Measurement late = carry_out(assay, synthetic_factory({.memory = 0.05, .jitter = 0.0, .step = 0.025}),
                                       synthetic_conditions(8), goal);
    EXPECT_LE(early.estimates[2].mean, 0.1);
    EXPECT_NEAR(early.estimates[1].mean, 0.01, 0.003);  // the square of the jitter
    EXPECT_GE(late.estimates[2].mean, 0.1);             // twice the memory
    const Measurement never =
        carry_out(assay, synthetic_factory({.memory = 3.0, .step = 0.025}), synthetic_conditions(8), goal);
    EXPECT_TRUE(std::isnan(never.estimates[2].mean));
    EXPECT_EQ(never.diagnosis.substr(0, 22), "no exponential regime:");
}

TEST(AssayDiagnosis, reports_motion_that_is_not_diffusive) {
    // Lags of 1 to 8 s; beads diffuse with D = 0.5, rods are ballistic, with 1 % noise from trial to trial.
    const Assay assay = diffusion({.warm_up = 0.0, .frame = 1.0, .time = 20.0, .min_lag = 1.0, .max_lag = 8.0});
    std::vector<Trial> trials;
    for (std::uint64_t t = 0; t < 32; ++t) {
        Trial noise(2);
        fill_normal({.seed = 5, .stream = Stream::test}, t, 1, noise);
        Trial trial;
        for (int lag = 1; lag <= 8; ++lag) trial.push_back((1.0 + 0.01 * noise[0]) * 2.0 * lag);
        for (int lag = 1; lag <= 8; ++lag) trial.push_back((1.0 + 0.01 * noise[1]) * lag * lag);
        trials.push_back(trial);
    }
    const auto decision = judge(assay, trials, {.max_trials = 32});
    ASSERT_TRUE(decision.measurement);
    const std::string& diagnosis = decision.measurement->diagnosis;
    EXPECT_EQ(diagnosis.substr(0, 77), "beads: the mean-square displacement is linear in time; rods: not diffusive: D");
    EXPECT_NEAR(decision.measurement->estimates[0].mean, 0.5, 0.01);
}

TEST(AssayRule, rejects_diffusion_plans_whose_lags_do_not_fit_the_trial) {
    EXPECT_NE(refusal_of([] { diffusion({.time = 2.0, .max_lag = 2.0}); }).find("longer than the longest lag"),
              std::string::npos);
    EXPECT_NE(refusal_of([] { diffusion({.min_lag = 0.5, .max_lag = 0.6}); }).find("expected at least 4 lags"),
              std::string::npos);
    EXPECT_NE(refusal_of([] { diffusion({.min_lag = 0.01}); }).find("at least one frame"), std::string::npos);
}

}  // namespace
}  // namespace drover::calibrate::assay_tests
