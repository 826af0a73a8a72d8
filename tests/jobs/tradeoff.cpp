// tests/jobs/tradeoff.cpp: wanted numbers, durations and the front of combinations.
#include "jobs/tradeoff/tradeoff.hpp"

#include <gtest/gtest.h>

#include "drover/base/error.hpp"
#include "drover/measure/statistics.hpp"
#include "io/scene.hpp"
#include "jobs/tradeoff/trade_axes.hpp"
#include "jobs/tradeoff/trade_front.hpp"
#include "run/fields/scene_equations.hpp"

namespace drover::jobs::tradeoff_tests {

TEST(AccuracyTarget, reads_a_name_a_range_and_a_relative_or_absolute_error) {
    const AccuracyTarget relative = parse_accuracy_target("polar_order=1%");
    EXPECT_EQ(relative.observable, "polar_order");
    EXPECT_DOUBLE_EQ(relative.error, 0.01);
    EXPECT_TRUE(relative.is_relative);
    const AccuracyTarget absolute = parse_accuracy_target(" polar_order = 0.02 ");
    EXPECT_DOUBLE_EQ(absolute.error, 0.02);
    EXPECT_FALSE(absolute.is_relative);
    const AccuracyTarget below = parse_accuracy_target("structure_factor_rods(q<1)=3%");
    ASSERT_EQ(below.ranges.size(), 1u);
    EXPECT_EQ(below.ranges[0].axis, "q");
    EXPECT_EQ(below.ranges[0].max, 1.0);
    EXPECT_EQ(below.ranges[0].min, -INFINITY);
    const AccuracyTarget between = parse_accuracy_target("structure_factor_rods(0.5 < wavenumber < 2)=3%");
    EXPECT_EQ(between.ranges[0].axis, "wavenumber");
    EXPECT_EQ(between.ranges[0].min, 0.5);
    EXPECT_EQ(between.ranges[0].max, 2.0);
    EXPECT_EQ(parse_accuracy_target("g(r>1)=3%").ranges[0].min, 1.0);
    const AccuracyTarget both = parse_accuracy_target("alignment(0.35<Phi_b<0.45, Phi_r<0.06)=5%");
    ASSERT_EQ(both.ranges.size(), 2u);
    EXPECT_EQ(both.ranges[1].axis, "Phi_r");
    EXPECT_EQ(both.ranges[1].max, 0.06);
}

TEST(AccuracyTarget, that_is_not_one_is_refused_with_the_form_expected) {
    for (const char* given : {"polar_order", "polar_order=", "polar_order=0%", "polar_order=-1%", "=1%",
                              "polar_order=x", "g(q=1)=1%", "g(q<x)=1%", "polar_order=inf"}) {
        try {
            parse_accuracy_target(given);
            ADD_FAILURE() << given;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("=1% (of its value)"), std::string::npos) << error.what();
        }
    }
}

TEST(PairedDifference, of_series_with_a_common_noise_knows_its_mean_better_than_each_series) {
    // b = noise, a = b + 0.1: the difference has no fluctuation at all.
    std::vector<double> a, b;
    std::uint64_t state = 1;
    for (int i = 0; i < 400; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        b.push_back(static_cast<double>(state >> 40) * 0x1p-24);
        a.push_back(b.back() + 0.1);
    }
    const measure::RoughMean difference = measure::paired_difference(a, b, 10);
    EXPECT_NEAR(difference.value, 0.1, 1e-14);  // rounding
    EXPECT_LT(difference.error, 1e-14);
    // A uniform number has the variance 1/12; 390 of them are independent, and blocks of them give the error to 30 %.
    EXPECT_NEAR(measure::rough_mean(b, 10).error, std::sqrt(1.0 / 12.0 / 390.0), 0.3 * std::sqrt(1.0 / 12.0 / 390.0));
}

namespace {
LevelFound level(const char* name, double bias, double bias_error, double start, double step) {
    return {.level = {name, {std::string("key=") + name}},
            .outcome = {},
            .biases = {{bias, bias_error}},
            .start_seconds = start,
            .step_seconds = step};
}

/// One target, of 1 +- 0.01; two steps, two grids and a simpler model; trials of 100 s with a standard error of 0.01.
Findings synthetic(bool statistical) {
    Findings found;
    found.targets = {parse_accuracy_target("polar_order=1%")};
    found.units = {"1"};
    found.references = {{1.0, 0.01}};
    found.allowed = {0.01};
    found.ladders = {{level("long", 0.008, 0.0, 0.0, 1.0), level("short", 0.002, 0.0, 0.0, 2.0)}};
    found.grids = {level("coarse", 0.02, 0.0, 0.25, 0.25), level("fine", 0.001, 0.0, 1.0, 1.0)};
    found.grids.back().level.overrides.clear();
    found.models = {level("full", 0.0, 0.0, 1.0, 1.0), level("simple", 0.004, 0.0, 1.0, 0.5)};
    found.models.front().level.overrides.clear();
    for (LevelFound& model : found.models) model.fluctuations = {{.error = 0.01, .time = 1.0, .margin = 1.0}};
    found.pilot_grid = 1;
    found.duration = 100.0;
    found.statistical = statistical;
    return found;
}
io::Scene scene_of_100_seconds() {
    io::Scene scene;
    scene.time.end = 100.0;
    return scene;
}
}  // namespace

TEST(StepLadders, have_the_first_order_of_noise_that_multiplies_fields_and_the_second_of_other_noise) {
    for (const bool multiplies : {false, true}) {
        const std::string toml = text(R"(
[[field]]
symbol = "u"
[[white_noise]]
symbol = "xi"
[equations]
u = "lap u - u + {}"
[grid]
nx = 16
ny = 16
[time]
dt = 0.1
end = 1.0
)",
                                      multiplies ? "u xi" : "xi");
        const std::vector<StepLadder> ladders = step_ladders(io::parse_scene(toml, "own.toml", {}));
        ASSERT_FALSE(ladders.empty());
        for (const StepLadder& ladder : ladders) EXPECT_EQ(ladder.order, multiplies ? 1.0 : 2.0) << ladder.method;
    }
}

TEST(TradeFront, of_definite_runs_adds_biases_and_multiplies_costs) {
    const Findings found = synthetic(false);
    const std::vector<Candidate> front = front_of(found, scene_of_100_seconds());
    for (std::size_t i = 1; i < front.size(); ++i) {
        EXPECT_GT(front[i].seconds, front[i - 1].seconds);
        EXPECT_LT(front[i].ratio, front[i - 1].ratio);
    }
    // short step, fine grid: simple model 0.002 + 0.001 + 0.004 = 0.7 of 0.01, at half of 2 s per second; long steps of
    // the full model cost the same, and have 0.008 + 0.001 = 0.9 of it.
    const Candidate* best = recommended(front, 1e9);
    ASSERT_NE(best, nullptr);
    EXPECT_EQ(best->model->level.name, "simple");
    EXPECT_EQ(best->step->level.name, "short");
    EXPECT_NEAR(best->ratio, 0.7, 1e-12);
    EXPECT_NEAR(best->seconds, 100.0, 1e-9);
    EXPECT_EQ(recommended(front, 99.0), nullptr);
}

TEST(TradeFront, of_noisy_runs_makes_them_as_long_as_the_target_needs) {
    const Findings found = synthetic(true);
    const std::vector<Candidate> front = front_of(found, scene_of_100_seconds());
    const Candidate* best = recommended(front, 1e9);
    ASSERT_NE(best, nullptr);
    // The standard error of T seconds is 0.01 sqrt(100/T); twice that must fit into 0.01 less the biases.  The best of
    // all: biases of 0.003 (full, short, fine), 2 s per second: T = 100 (0.02/0.007)^2 = 816 s, 1633 s; simple: 0.007,
    // 1 s per second: T = 4444 s.  Of durations the one that just suffices is tried, with 2 % for rounding.
    EXPECT_EQ(best->model->level.name, "full");
    EXPECT_EQ(best->step->level.name, "short");
    EXPECT_GE(best->end, 816.0);
    EXPECT_LE(best->end, 816.0 * 1.02 + 2.0);
    EXPECT_LE(best->ratio, 1.0);
}

TEST(TradeFront, counts_what_rare_samples_cost) {
    // With samples far rarer than correlations, which last 1 s, the variance of a mean over T is that of T/20 numbers
    // instead of T/2: the error sqrt(10) times that of the trials, and eight blocks of ten take 800 s.
    Findings found = synthetic(true);
    for (std::vector<LevelFound>& ladder : found.ladders)
        for (LevelFound& level : ladder) level.level.sample_every = 20.0;
    found.sample_every = 0.1;
    for (const Candidate& one : front_of(found, scene_of_100_seconds())) {
        if (one.step == nullptr) continue;
        EXPECT_GE(one.end, 800.0);
        EXPECT_NEAR(one.parts.front().statistics, 0.01 * std::sqrt(10.0 * 100.0 / one.end), 1e-6);
    }
}

TEST(TradeFront, of_a_model_that_fluctuates_otherwise_has_its_own_errors_and_durations) {
    // The simple model has correlations nine times as long at the same variance: three times the error, and eight
    // blocks of ten of its correlations take 720 s.
    Findings found = synthetic(true);
    found.models.back().fluctuations = {{.error = 0.03, .time = 9.0, .margin = 1.0}};
    for (const Candidate& one : front_of(found, scene_of_100_seconds(), &found.models.back())) {
        EXPECT_GE(one.end, 720.0);
        EXPECT_NEAR(one.parts.front().statistics, 0.03 * std::sqrt(100.0 / one.end), 1e-6);
    }
    for (const Candidate& one : front_of(found, scene_of_100_seconds(), &found.models.front()))
        EXPECT_NEAR(one.parts.front().statistics, 0.01 * std::sqrt(100.0 / one.end), 1e-6);
    // A trial of a combination tells its own: a fifth of the time, and a fifth of the error.
    const Candidate first = front_of(found, scene_of_100_seconds(), &found.models.back()).front();
    found.checked.push_back({.overrides = overrides_of(first),
                             .outcome = {},
                             .biases = {{0.0, 0.0}},
                             .fluctuations = {{.error = 0.006, .time = 1.8, .margin = 1.0}}});
    const Candidate checked = front_of(found, scene_of_100_seconds(), &found.models.back()).front();
    ASSERT_EQ(overrides_of(checked), overrides_of(first));
    EXPECT_GE(checked.end, 144.0);
    EXPECT_NEAR(checked.parts.front().statistics, 0.006 * std::sqrt(100.0 / checked.end), 1e-6);
}

TEST(TradeFront, replaces_sums_of_biases_by_those_of_a_trial_and_drops_what_failed) {
    Findings found = synthetic(false);
    const io::Scene scene = scene_of_100_seconds();
    const std::vector<Candidate> before = front_of(found, scene);
    found.checked.push_back({.overrides = overrides_of(*recommended(before, 1e9)),
                             .outcome = {},
                             .biases = {{0.02, 0.0}},
                             .fluctuations = {}});
    const std::vector<Candidate> worse = front_of(found, scene);
    const Candidate* best = recommended(worse, 1e9);
    ASSERT_NE(best, nullptr);
    EXPECT_FALSE(best->parts.front().whole.has_value());
    EXPECT_EQ(best->model->level.name, "full");
    found.checked.front().outcome = {LevelState::failed, "unstable"};
    const std::vector<Candidate> failed = front_of(found, scene);
    for (const Candidate& one : failed) EXPECT_NE(overrides_of(one), found.checked.front().overrides);
}

TEST(BiasOfFinest, is_what_is_left_of_the_waves_on_a_line_and_small_where_fields_are_smooth) {
    // White noise on a line leaves out c/N: 32, 64 and 128 points differ by c/64 and c/128, and the last lacks c/128.
    const double c = 3.0, error = 1e-3;
    const Bias longer{-c / 64.0, error}, last{-c / 128.0, error};
    for (const Bias& before : {longer, Bias{}}) {  // seen, and taken as usual where there are two grids
        const Bias found = bias_of_finest(before, last, true);
        EXPECT_NEAR(found.value, -c / 128.0, 2.0 * found.error);
        EXPECT_LT(found.error, 0.5 * c / 128.0);
    }
    // Steps that shrink by 1/8 leave 1/7 of the last.
    EXPECT_NEAR(bias_of_finest({0.8, 1e-4}, {0.1, 1e-4}, true).value, 0.1 / 7.0, 1e-4);
    EXPECT_DOUBLE_EQ(bias_of_finest(longer, last, false).value, -c / 384.0);
}

TEST(Converges, only_where_steps_between_grids_shrink_or_are_small) {
    const std::vector<double> allowed{0.01};
    EXPECT_TRUE(converges({{{0.2, 1e-4}}, {{0.1, 1e-4}}}, allowed));
    EXPECT_FALSE(converges({{{0.2, 1e-4}}, {{0.19, 1e-4}}}, allowed));  // as of a logarithm
    EXPECT_FALSE(converges({{{}}, {{0.1, 1e-4}}}, allowed));
    EXPECT_TRUE(converges({{{}}, {{0.002, 1e-4}}}, allowed));
}

TEST(ModelLevels, keep_the_modes_of_the_full_model) {
    const io::Scene scene = io::parse_scene(R"(
field = [{symbol = "h", noise = "1"}]
equations = {h = "-a h + lap h - b h^3"}
coefficients = {a = 1.0, b = 2.0}
grid = {nx = 32, ny = 32, lx = 16.0, ly = 16.0}
)",
                                            "h.toml", {});
    int compared = 0;
    for (const AxisLevel& level : model_levels(scene))
        if (level.name == "without b" || level.name == "without a") {
            EXPECT_EQ(run::integrated_of(io::changed(scene, level.overrides)).kept_degree, 3) << level.name;
            ++compared;
        }
    EXPECT_EQ(compared, 2);
}

TEST(CellLevels, have_the_density_of_bodies_of_the_scene) {
    for (const char* beads : {"area_fraction = 0.5", "count = 40"}) {
        const io::Scene scene =
            io::parse_scene(text("cell = {{lx = 10.0, ly = 8.0}}\nbeads = {{{}}}\n", beads), "", {});
        const std::optional<AxisLevel> level = larger_cell(scene);
        ASSERT_TRUE(level);
        const dem::Setup larger = io::changed(scene, level->overrides).particles;
        EXPECT_EQ(larger.cell.lx * larger.cell.ly, 4.0 * 80.0);
        EXPECT_EQ(larger.beads.count, 4 * scene.particles.beads.count);
        EXPECT_EQ(larger.beads.area_fraction, scene.particles.beads.area_fraction);
    }
}

TEST(LongerDuration, is_a_whole_multiple_of_that_of_the_trials_whatever_may_be_spent) {
    // The trials last 16 steps of 0.8 s; 145.4 s would be no whole number of these.
    for (const double affordable : {25.7, 100.0, 145.4, 1e6 / 3.0}) {
        const double times = longer_duration(12.8, affordable) / 12.8;
        EXPECT_DOUBLE_EQ(times, std::floor(affordable / 12.8));
    }
    EXPECT_EQ(longer_duration(12.8, 25.5), 0.0);
}

}  // namespace drover::jobs::tradeoff_tests
