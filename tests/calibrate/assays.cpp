// tests/calibrate/assays.cpp: every assay recovers the known coefficients of a synthetic system, with correct errors.
#include <gtest/gtest.h>

#include <memory>

#include "calibrate/catalogue.hpp"
#include "calibrate/synthetic.hpp"
#include "calibrate/table.hpp"

namespace drover::calibrate::assays_tests {
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
Case drag_case(const std::vector<double>& torques = {100.0, 250.0, 600.0, 2000.0}) {
    return {.assay = drag({.torques = torques, .warm_up = 0.1, .time = 1.6, .frame = 0.05}),
            .truth = {.turning = 0.1, .damping = 2.0, .drag = 3.0, .drag_cubic = -1.0, .agitation = 0.2, .step = 0.025},
            .values = {{0, 3.0}, {1, -1.0}, {2, 0.5}}};
}
Case drag_with_reversal_case() { return drag_case({-1500.0, 600.0, 1200.0, 2000.0}); }
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
Case stiffness_among_rods_case() {
    return {.assay = stiffness({.among_rods = true, .warm_up = 0.0, .settle = 2.0, .time = 1.0, .frame = 0.05}),
            .truth = {.diffusion = 0.4, .stiffness = 500.0, .rods_follow = -0.4, .step = 2.0},
            .rods = 60,
            .values = {{0, 500.0}, {2, 1.0}, {3, -0.4}},
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

Case rotation_case() {
    // Jitter of the axis adds an offset to the squares of the angles, twice its variance; relaxation has the same D_r.
    return {.assay = rotation({.warm_up = 0.0, .frame = 0.05, .time = 4.0, .min_lag = 0.1, .max_lag = 0.5}),
            .truth = {.diffusion = 0.5, .jitter = 0.1, .speed = 2.0, .step = 0.01},
            .values = {{0, 0.5}, {1, 2.0 * 0.01}, {2, 0.0}},
            .coverage_error = 0.045};
}

/// All cases, by name.
Case case_of(const std::string& name) {
    if (name == "relaxation") return relaxation_case();
    if (name == "weathercock") return weathercock_case(0.3);
    if (name == "weathercock_against_the_flow") return weathercock_case(-0.2);
    if (name == "drag") return drag_case();
    if (name == "drag_with_reversal") return drag_with_reversal_case();
    if (name == "damping") return damping_case(0.0);
    if (name == "damping_coulomb") return damping_case(60.0);
    if (name == "shear") return shear_case();
    if (name == "propulsion") return propulsion_case();
    if (name == "diffusion") return diffusion_case();
    if (name == "rotation") return rotation_case();
    if (name == "stiffness_among_rods") return stiffness_among_rods_case();
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
        ASSERT_TRUE(estimate.error) << c.assay.quantities[place].name << ": " << estimate.why_no_error;
        EXPECT_NEAR(estimate.mean, value, 3.0 * *estimate.error) << c.assay.quantities[place].name;
        if (c.assay.quantities[place].wanted) {
            EXPECT_LE(*estimate.error, 0.02 * std::abs(estimate.mean));
        }
        RecordProperty(c.assay.quantities[place].name, text("{} +- {}", estimate.mean, *estimate.error));
    }
}

TEST(DragAssay, turns_the_rods_round_and_keeps_the_straight_line_of_the_others) {
    const Case c = drag_with_reversal_case();
    const Measurement found = carry_out(c.assay, synthetic_factory(c.truth), synthetic_conditions(c.rods, 7, c.beads),
                                        {.relative_error = 0.02, .max_trials = 4096});
    std::map<std::string, double> means;
    for (std::size_t i = 0; i < found.estimates.size(); ++i)
        means[c.assay.quantities[i].name] = found.estimates[i].mean;
    EXPECT_LT(means.at("order_-1500"), -0.5);
    // v = 3 P - P^3 by a line through windows of these orders: 3 - <P^4>/<P^2>.
    EXPECT_LT(means.at("drag_straight"), 3.0 - std::pow(means.at("order_600") - 0.05, 2));
    EXPECT_GT(means.at("drag_straight"), 3.0 - std::pow(means.at("order_2000") + 0.05, 2));
}

TEST(StiffnessAssay, among_rods_holds_them_across_the_force) {
    struct Watched : SyntheticSystem {
        using SyntheticSystem::SyntheticSystem;
        void impose(const dem::BodyForces& forces) override {
            EXPECT_NEAR(forces.angle, 0.5 * std::numbers::pi, 1e-15);
            EXPECT_EQ(forces.torque, 300.0);
            SyntheticSystem::impose(forces);
        }
    };
    const Case c = stiffness_among_rods_case();
    const SystemFactory make = [&](const dem::Setup& setup, std::uint64_t seed) {
        EXPECT_GT(setup.rods.count, 0);
        return std::make_unique<Watched>(c.truth, setup, seed);
    };
    EXPECT_EQ(run_trial(c.assay, make, synthetic_conditions(c.rods), 0).size(), 5u);
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

/// Rods that align with the flow, g = 0.75, and by contacts, g_c = 1.2.
constexpr Truth aligning{.turning = 0.1, .diffusion = 0.4, .jitter = 0.0, .contact = 1.2, .drag = 3.0, .step = 0.1};
/// c sigma = a g_c/2, at Phi_r = 0.1 and 4 mm^2 a rod.
constexpr double true_contact = 0.5 * 0.4 * 1.2 * 4.0 / 0.1;

/// Assays that give c, in fields that are far from lasting as long as 1/a = 2.5 s.
Assay contact_assay(bool held) {
    const std::vector<double> torques{60.0, 250.0, 800.0};
    return held ? alignment({.torques = torques, .warm_up = 0.1, .time = 2.0, .windows = 4, .frame = 0.1})
                : drag({.torques = torques, .warm_up = 0.1, .time = 2.0, .frame = 0.1});
}

/// A table of these measurements, of a world whose a and lambda are known.
Table contact_table(bool held, std::uint64_t seed) {
    const Assay assay = contact_assay(held);
    const Measurement found = carry_out(assay, synthetic_factory(aligning), synthetic_conditions(40, seed),
                                        {.relative_error = 1.0, .round = 8, .max_trials = 16});
    Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {0.1}, .rows = {}};
    const auto add = [&](const std::string& name, double value, double error, bool by_rods) {
        table.rows.push_back({.name = name,
                              .unit = "x",
                              .formula = "x",
                              .by_rods = by_rods,
                              .entries = {{.value = value, .error = error, .origin = Origin::measured}}});
    };
    add("relaxation_rate", aligning.diffusion, 0.0, false);
    add("weathercock", 0.5 * aligning.turning, 0.0, false);
    add("rod_area", 4.0, 0.0, false);
    for (std::size_t q = 0; q < assay.quantities.size(); ++q) {
        const std::string& name = assay.quantities[q].name;
        if (name == "drag" || name.starts_with("alignment_") || name.starts_with("contact_"))
            add(name, found.estimates[q].mean, *found.estimates[q].error, true);
    }
    add_derived(table);
    return table;
}

class ContactAlignment : public testing::TestWithParam<bool> {};
class ContactAlignmentStatistics : public testing::TestWithParam<bool> {};

TEST_P(ContactAlignment, is_recovered_within_three_errors) {
    const Table table = contact_table(GetParam(), 7);
    const TableEntry& c = find_row(table, "contact_alignment")->entries.front();
    EXPECT_EQ(c.origin, Origin::measured);
    EXPECT_NEAR(c.value, true_contact, 3.0 * c.error);
    EXPECT_LT(c.error, 0.4 * true_contact);
}

TEST_P(ContactAlignmentStatistics, has_errors_that_cover_the_true_value_in_68_percent_of_repeats) {
    constexpr int repeats = 200;
    int covered = 0;
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < repeats; ++i) {
        const Table table = contact_table(GetParam(), 500 + static_cast<std::uint64_t>(i));
        const TableEntry& c = find_row(table, "contact_alignment")->entries.front();
        const double wrong = (c.value - true_contact) / c.error;
        covered += std::abs(wrong) <= 1.0;
        sum += wrong, squares += wrong * wrong;
    }
    EXPECT_NEAR(covered, 0.683 * repeats, 3.0 * std::sqrt(0.683 * 0.317 * repeats));
    RecordProperty("mean_and_spread_in_errors", text("{} {}", sum / repeats, std::sqrt(squares / repeats)));
}
const auto assay_of = [](const auto& info) { return std::string(info.param ? "from_held_beads" : "from_free_beads"); };
INSTANTIATE_TEST_SUITE_P(All, ContactAlignment, testing::Bool(), assay_of);
INSTANTIATE_TEST_SUITE_P(All, ContactAlignmentStatistics, testing::Bool(), assay_of);

constexpr const char* names[] = {"relaxation",
                                 "weathercock",
                                 "weathercock_against_the_flow",
                                 "drag",
                                 "damping",
                                 "damping_coulomb",
                                 "shear",
                                 "propulsion",
                                 "stiffness",
                                 "diffusion",
                                 "rotation",
                                 "stiffness_among_rods",
                                 "drag_with_reversal"};
const auto name_of = [](const auto& info) { return std::string(info.param); };
INSTANTIATE_TEST_SUITE_P(All, Assays, testing::ValuesIn(names), name_of);
INSTANTIATE_TEST_SUITE_P(All, AssaysStatistics, testing::ValuesIn(names), name_of);

}  // namespace
}  // namespace drover::calibrate::assays_tests
