// tests/calibrate/assays.cpp: every assay recovers the known coefficients of a synthetic system, with correct errors.
#include <gtest/gtest.h>

#include <memory>

#include "calibrate/synthetic.hpp"
#include "drover/calibrate/catalogue.hpp"

namespace drover::calibrate {
namespace {

/// A shortened assay, a synthetic system, and the true values of quantities by their index.
struct Case {
    Assay assay;
    Truth truth;
    int rods = 4, beads = 900;
    std::map<std::size_t, double> values;  ///< of the quantities to check
    double coverage_error = 0.05;          ///< target in the 200 repeats, such that some need more than one evaluation
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

Case diffusion_case() {
    // Rattling of 0.1 mm adds an offset to the displacements of beads; propulsion and rotation must not add to rods.
    return {.assay = diffusion({.warm_up = 0.0, .frame = 0.1, .time = 4.0, .min_lag = 0.2, .max_lag = 1.0}),
            .truth = {.diffusion = 0.5,
                      .jitter = 0.0,
                      .speed = 2.0,
                      .bead_diffusion = 0.3,
                      .bead_rattle = 0.1,
                      .rod_diffusion = 0.2,
                      .step = 0.02},
            .beads = 6,
            .values = {{0, 0.3}, {1, 0.2}, {2, 4.0 * 0.01}, {3, 0.0}, {4, 0.0}, {5, 0.0}},
            .coverage_error = 0.05};
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
    if (name == "diffusion") return diffusion_case();
    return stiffness_case();
}

class Assays : public testing::TestWithParam<const char*> {};
class AssaysStatistics : public testing::TestWithParam<const char*> {};

TEST_P(Assays, recover_known_coefficients_within_three_errors) {
    const Case c = case_of(GetParam());
    const Measurement found = carry_out(c.assay, synthetic_factory(c.truth), synthetic_conditions(c.rods, 7, c.beads),
                                        {.relative_error = 0.02, .max_trials = 4096});
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

TEST_P(AssaysStatistics, have_errors_that_cover_the_true_value_in_68_percent_of_repeats) {
    // One standard error covers 68.3 %; 3 standard deviations of the binomial distribution of 200 repeats are 9.9 %.
    // The stopping rule applies to each repeat separately.
    const Case c = case_of(GetParam());
    constexpr int repeats = 200;
    std::map<std::size_t, int> covered;
    std::size_t trials = 0;
    for (int i = 0; i < repeats; ++i) {
        const Measurement found = carry_out(c.assay, synthetic_factory(c.truth),
                                            synthetic_conditions(c.rods, 100 + static_cast<std::uint64_t>(i), c.beads),
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
    EXPECT_GT(trials, 33u * repeats);  // some repeats needed more rounds
}

constexpr const char* names[] = {"relaxation", "weathercock", "weathercock_against_the_flow",
                                 "drag",       "damping",     "damping_coulomb",
                                 "shear",      "propulsion",  "stiffness",
                                 "diffusion"};
const auto name_of = [](const auto& info) { return std::string(info.param); };
INSTANTIATE_TEST_SUITE_P(All, Assays, testing::ValuesIn(names), name_of);
INSTANTIATE_TEST_SUITE_P(All, AssaysStatistics, testing::ValuesIn(names), name_of);

}  // namespace
}  // namespace drover::calibrate
