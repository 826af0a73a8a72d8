// tests/calibrate/assays.cpp: each assay on a stand-in of known coefficients finds them, with an error that is honest.
#include <gtest/gtest.h>

#include <memory>

#include "calibrate/synthetic.hpp"
#include "drover/calibrate/catalogue.hpp"

namespace drover::calibrate {
namespace {

/// An assay shortened for tests, a stand-in, and the true values of quantities by their place.
struct Case {
    Assay assay;
    Truth truth;
    int rods = 4;
    std::map<std::size_t, double> values;  ///< of those that are checked
    double coverage_error = 0.05;          ///< asked in the 200 repeats: so that some go on beyond the first look
};

Case relaxation_case() {
    return {.assay = relaxation({.warm_up = 0.5, .frame = 0.05, .time = 4.0, .max_lag = 1.5}),
            .truth = {.diffusion = 0.4, .memory = 0.05, .step = 0.05},
            .values = {{0, 0.4}}};
}
Case weathercock_case(double turning) {
    return {.assay = weathercock({.warm_up = 0.0, .align = 0.5, .settle = 0.0, .frame = 0.05}),
            .truth = {.turning = turning, .diffusion = 0.2, .step = 0.05},
            .rods = 4,
            .values = {{0, turning}, {1, 0.5 * turning}, {2, 1.0}, {3, turning}, {6, turning}},
            .coverage_error = turning > 0.0 ? 0.018 : 0.023};
}
Case drag_case() {
    return {.assay = drag({.torques = {100.0, 250.0, 600.0, 2000.0}, .warm_up = 0.1, .time = 1.6, .frame = 0.05}),
            .truth = {.turning = 0.1, .damping = 2.0, .drag = 3.0, .drag_cubic = -1.0, .agitation = 0.2, .step = 0.025},
            .values = {{0, 3.0}, {1, -1.0}, {2, 0.5}}};
}
Case damping_case(double coulomb) {
    return {.assay = damping({.warm_up = 0.0, .hold = 0.01, .time = 0.2, .frame = 0.005}),
            .truth = {.damping = 20.0, .coulomb = coulomb, .agitation = 0.2, .step = 0.005},
            .rods = 0,
            .values = {{0, 20.0 + coulomb / 3.0}, {1, 20.0}, {2, coulomb}, {3, coulomb / (coulomb + 60.0)}},
            .coverage_error = coulomb > 0.0 ? 0.0055 : 0.007};
}
Case shear_case() {
    const auto rate = [](int k) { return 5.0 + 6.0 * std::pow(2.0 * std::numbers::pi * k / 30.0, 2); };
    return {.assay = shear({.warm_up = 0.0, .hold = 0.01, .time = 0.3, .frame = 0.01}),
            .truth = {.damping = 5.0, .viscosity = 6.0, .step = 0.01},
            .rods = 0,
            .values = {{0, 6.0}, {1, 5.0}, {3, rate(1)}, {5, rate(5)}},
            .coverage_error = 0.027};
}
Case propulsion_case() {
    return {.assay = propulsion({.warm_up = 0.5, .time = 1.0, .frame = 0.05}),
            .truth = {.diffusion = 1.0, .jitter = 0.3, .speed = 3.6, .step = 0.01},
            .values = {{0, 3.6}},
            .coverage_error = 0.0014};
}
Case stiffness_case() {
    return {.assay = stiffness({.warm_up = 0.0, .settle = 2.0, .time = 1.0, .frame = 0.05}),
            .truth = {.stiffness = 500.0, .step = 2.0},
            .rods = 0,
            .values = {{0, 500.0}, {2, 1.0}},
            .coverage_error = 0.013};
}

/// All cases, by name.
Case case_of(const std::string& name) {
    if (name == "relaxation") return relaxation_case();
    if (name == "weathercock") return weathercock_case(0.3);
    if (name == "weathercock_against_the_flow") return weathercock_case(-0.2);
    if (name == "drag") return drag_case();
    if (name == "damping") return damping_case(0.0);
    if (name == "damping_coulomb") return damping_case(60.0);
    if (name == "shear") return shear_case();
    if (name == "propulsion") return propulsion_case();
    return stiffness_case();
}

class Assays : public testing::TestWithParam<const char*> {};
class AssaysStatistics : public testing::TestWithParam<const char*> {};

TEST_P(Assays, find_the_coefficients_of_a_stand_in_within_three_errors) {
    const Case c = case_of(GetParam());
    const Measurement found =
        carry_out(c.assay, synthetic_maker(c.truth), stand_in(c.rods, 7), {.relative_error = 0.02, .max_trials = 4096});
    EXPECT_TRUE(found.reached) << found.unmet_target;
    ASSERT_EQ(found.estimates.size(), c.assay.quantities.size());
    for (const auto& [place, value] : c.values) {
        const measure::Estimate& estimate = found.estimates[place];
        ASSERT_TRUE(estimate.error) << c.assay.quantities[place].name << ": " << estimate.refusal;
        EXPECT_NEAR(estimate.mean, value, 3.0 * *estimate.error) << c.assay.quantities[place].name;
        if (c.assay.quantities[place].wanted) {
            EXPECT_LE(*estimate.error, 0.02 * std::abs(estimate.mean));
        }
        RecordProperty(c.assay.quantities[place].name, text("{} +- {}", estimate.mean, *estimate.error));
    }
}

TEST_P(AssaysStatistics, have_errors_that_cover_the_truth_as_often_as_they_say) {
    // One standard error covers 68.3 %; among 200 repeats 3 standard deviations of the binomial are 9.9 %.  The rule stops each repeat by itself.
    const Case c = case_of(GetParam());
    constexpr int repeats = 200;
    std::map<std::size_t, int> covered;
    std::size_t trials = 0;
    for (int i = 0; i < repeats; ++i) {
        const Measurement found =
            carry_out(c.assay, synthetic_maker(c.truth), stand_in(c.rods, 100 + static_cast<std::uint64_t>(i)),
                      {.relative_error = c.coverage_error});
        EXPECT_TRUE(found.reached) << found.unmet_target;
        trials += found.trials;
        for (const auto& [place, value] : c.values) {
            const measure::Estimate& estimate = found.estimates[place];
            if (estimate.error && std::abs(estimate.mean - value) <= *estimate.error) ++covered[place];
        }
    }
    const double expected = 0.683 * repeats, deviation = std::sqrt(0.683 * 0.317 * repeats);
    for (const auto& [place, value] : c.values)
        EXPECT_NEAR(covered[place], expected, 3.0 * deviation) << c.assay.quantities[place].name;
    EXPECT_GT(trials, 33u * repeats);  // the rule did go on where errors were too large
}

constexpr const char* names[] = {"relaxation", "weathercock", "weathercock_against_the_flow",
                                 "drag",       "damping",     "damping_coulomb",
                                 "shear",      "propulsion",  "stiffness"};
const auto name_of = [](const auto& info) { return std::string(info.param); };
INSTANTIATE_TEST_SUITE_P(All, Assays, testing::ValuesIn(names), name_of);
INSTANTIATE_TEST_SUITE_P(All, AssaysStatistics, testing::ValuesIn(names), name_of);

}  // namespace
}  // namespace drover::calibrate
