// tests/calibrate/onset.cpp: predicted flocking thresholds of tables with known crossings.
#include "calibrate/onset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/refusal.hpp"
#include "calibrate/closures.hpp"
#include "calibrate/field_model.hpp"

namespace drover::calibrate::onset_tests {
namespace {

/// alpha/Gamma = 1 + 4 Phi_b + 10 Phi_r, a = 0.3, lambda = 0.1: splines are exact for straight lines, and the threshold
/// is 3 mm/s.
Table straight_table(double error = 0.05) {
    Table table{.varied_key = {},
                .bead_fractions = {0.2, 0.3, 0.5, 0.7},
                .rod_fractions = {0.05, 0.08, 0.11},
                .rows = {}};
    TableRow drag{.name = "drag", .unit = "mm/s", .formula = "x", .by_rods = true},
        a{.name = "relaxation_rate", .unit = "1/s", .formula = "x"},
        lambda{.name = "weathercock", .unit = "1/mm", .formula = "x"};
    for (const double bead : table.bead_fractions) {
        for (const double rod : table.rod_fractions)
            drag.entries.push_back(
                {.value = 1.0 + 4.0 * bead + 10.0 * rod, .error = error, .trials = 20, .origin = Origin::measured});
        a.entries.push_back({.value = 0.3, .error = 0.0, .trials = 20, .origin = Origin::measured});
        lambda.entries.push_back({.value = 0.1, .error = 0.0, .trials = 20, .origin = Origin::measured});
    }
    table.rows = {drag, a, lambda};
    return table;
}

TEST(Onset, is_where_the_flow_of_aligned_rods_exceeds_the_threshold) {
    const Onset onset = find_onset(straight_table(0.005));  // so small that every redrawn table crosses
    ASSERT_EQ(onset.curves.size(), 3u);
    ASSERT_EQ(onset.plane.size(), 21u);
    EXPECT_EQ(onset.bead_fractions.size(), 31u);
    for (const OnsetCurve& point : onset.plane) {
        // 1 + 4 Phi_b + 10 Phi_r = 3; with lambda_s for lambda 1.5, which this table exceeds at its first node.
        const double exact = 0.5 - 2.5 * point.rod_fraction;
        const Crossings& mean = point.crossings[0];
        ASSERT_EQ(mean.all.size(), 1u);
        EXPECT_NEAR(mean.all[0].bead_fraction, exact, 1e-9) << point.rod_fraction;
        EXPECT_TRUE(mean.all[0].begins && mean.all[0].is_alone);
        EXPECT_NEAR(mean.as_many, 1.0, 1e-12);
        EXPECT_TRUE(point.crossings[1].all.empty());
        EXPECT_TRUE(point.crossings[1].above_all);
    }
    for (const OnsetCurve& curve : onset.curves)
        for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i) {
            EXPECT_NEAR(curve.drag[i].value, 1.0 + 4.0 * onset.bead_fractions[i] + 10.0 * curve.rod_fraction, 1e-12);
            EXPECT_NEAR(curve.threshold[i].value, 3.0, 1e-12);
        }
}

TEST(Onset, has_the_error_of_the_curve_divided_by_its_slope) {
    const Table table = straight_table();
    const Onset onset = find_onset(table);
    const SmoothCoefficient drag(table, "drag");
    for (const OnsetCurve& curve : onset.curves) {
        ASSERT_EQ(curve.crossings[0].all.size(), 1u);
        const Crossing& mean = curve.crossings[0].all[0];
        const double expected = drag.at(mean.bead_fraction, curve.rod_fraction).error / 4.0;
        // A distance of quantiles of 400 draws is known to 5 %; the slope of the curve varies by a few percent.
        EXPECT_NEAR(0.5 * (mean.high - mean.low), expected, 0.15 * expected) << curve.rod_fraction;
    }
    const auto low = [](const Onset& of) { return of.plane[3].crossings[0].all[0].low; };
    EXPECT_EQ(low(find_onset(table)), low(onset));  // drawn by counter
}

/// g = 4 Phi_b from the orders of many rods, known to 0.1, and a flow whose share of it is hardly known.
Table table_of_measured_alignment() {
    Table table{.varied_key = {}, .bead_fractions = {0.3, 0.4, 0.5, 0.6, 0.7}, .rod_fractions = {0.08}, .rows = {}};
    const auto add = [&](const char* name, bool by_rods, double error, auto value) {
        TableRow row{.name = name, .unit = "1", .formula = "x", .by_rods = by_rods};
        for (const double bead : table.bead_fractions)
            row.entries.push_back({.value = value(bead), .error = error, .trials = 20, .origin = Origin::measured});
        table.rows.push_back(row);
    };
    add("relaxation_rate", false, 0.01, [](double) { return 0.1; });
    add("weathercock", false, 0.02, [](double bead) { return 0.06 * bead; });
    add("drag", true, 0.3, [](double) { return 1.5; });
    add("rod_area", false, 0.0, [](double) { return 4.0; });
    add("propulsion", false, 0.0, [](double) { return 3.0; });
    add("alignment_steady", true, 0.1, [](double bead) { return 4.0 * bead; });
    add("alignment_drift", true, 0.0, [](double) { return 0.0; });
    add("alignment_reference", true, 0.1, [](double bead) { return 4.0 * bead; });
    add("response_time", true, 0.1, [](double) { return 1.0; });
    add_derived(table);
    return table;
}

TEST(Onset, has_the_error_of_the_measured_alignment_however_flow_and_contacts_share_it) {
    // The flow is known to 70 % (0.9 of g at 0.5): drawn apart from c it would give an error of 0.16, not 0.1/4.
    const Table table = table_of_measured_alignment();
    const Crossings found = find_onset(table).curves[0].crossings[0];
    ASSERT_EQ(found.all.size(), 1u);
    const Crossing& crossing = found.all[0];
    EXPECT_NEAR(crossing.bead_fraction, 0.5, 1e-6);  // a node: c is exact there
    // 400 tables: 5 %; c and lambda are not straight lines.
    EXPECT_NEAR(0.5 * (crossing.high - crossing.low), 0.1 / 4.0, 0.2 * 0.1 / 4.0);
    const Uncertain g = mean_field(table, {.bead_fraction = 0.5, .rod_fraction = 0.08}).alignment;
    EXPECT_NEAR(g.value, 2.0, 1e-9);
    EXPECT_NEAR(g.error, 0.1, 0.02);  // half the distance of two quantiles of 200: 7 %
    const Uncertain w =
        field_number(table, "advection.strength", {.bead_fraction = 0.5, .rod_fraction = 0.08}, OrderKind::orientation)
            .number;
    EXPECT_NEAR(w.value, 3.0 / 16.0 * 2.0 * 3.0, 1e-9);
    EXPECT_NEAR(w.error, 3.0 / 16.0 * 0.1 * 3.0, 0.2 * 3.0 / 16.0 * 0.1 * 3.0);
}

TEST(Onset, gives_the_fraction_of_draws_with_a_crossing) {
    // 3 mm/s at the last node: half of the draws reach it.
    Table table = straight_table();
    for (TableEntry& entry : table.rows[0].entries) entry.value -= 0.9 + 1e-6;
    const Crossings found = find_onset(table).curves[0].crossings[0];  // 0.1 + 4 Phi_b + 0.5 < 3 up to 0.6...
    ASSERT_EQ(found.all.size(), 1u);
    EXPECT_NEAR(found.all[0].bead_fraction, 0.6 + 2.5e-7, 1e-6);
    for (TableEntry& entry : table.rows[0].entries) entry.value -= 0.4;
    const Crossings edge = find_onset(table).curves[0].crossings[0];
    EXPECT_TRUE(edge.all.empty());
    EXPECT_FALSE(edge.above_all);
    EXPECT_NEAR(edge.share.back(), 0.5, 0.01);  // of the draws of one number half are above it
    // About a half; some cross before the last node and fall back.
    EXPECT_NEAR(edge.any, 0.5, 0.1);
    EXPECT_EQ(edge.more, edge.any);
}

/// alpha/Gamma = 3.1 and an excursion below 3 at one node, of this depth.
Table table_with_a_dip(double depth) {
    Table table = straight_table(0.1);
    table.bead_fractions = {0.2, 0.4, 0.6, 0.8};
    for (std::size_t i = 0; i < table.rows[0].entries.size(); ++i)
        table.rows[0].entries[i].value = i / 3 == 0 ? 2.0 : i / 3 == 2 ? 3.0 - depth : 3.6;
    return table;
}

TEST(Onset, gives_all_crossings_and_those_that_are_within_errors_of_none) {
    const Crossings clear = find_onset(table_with_a_dip(0.6)).curves[0].crossings[0];
    ASSERT_EQ(clear.all.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(clear.all[i].begins, i != 1);
        EXPECT_TRUE(clear.all[i].is_alone) << i;
        EXPECT_LT(clear.all[i].low, clear.all[i].bead_fraction);
        EXPECT_GT(clear.all[i].high, clear.all[i].bead_fraction);
    }
    EXPECT_NEAR(clear.as_many, 1.0, 0.01);
    // The dip is half of its error deep: 69 % of the draws have it, and both its crossings lie in one band.
    const Crossings unclear = find_onset(table_with_a_dip(0.05)).curves[0].crossings[0];
    ASSERT_EQ(unclear.all.size(), 3u);
    EXPECT_TRUE(unclear.all[0].is_alone);
    EXPECT_FALSE(unclear.all[1].is_alone || unclear.all[2].is_alone);
    EXPECT_NEAR(unclear.all[1].low, unclear.all[2].low, 5e-3);
    // Beside the node the curve lies somewhat lower; one node has the draws of one number.
    EXPECT_NEAR(unclear.as_many, 0.69, 0.1);
}

TEST(OnsetLong, moves_to_fewer_beads_where_rods_align_by_contacts) {
    // lambda alpha/Gamma + c sigma = a, sigma = Phi_r/4, c = 2: 0.1 (1 + 4 Phi_b + 10 Phi_r) + Phi_r/2 = 0.3.
    Table table = straight_table(0.005);
    for (const auto& [name, value] : {std::pair{"contact_alignment", 2.0}, std::pair{"rod_area", 4.0}})
        table.rows.push_back({.name = name,
                              .unit = "x",
                              .formula = "x",
                              .entries = std::vector<TableEntry>(4, {.value = value, .origin = Origin::measured})});
    const Onset onset = find_onset(table);
    for (const OnsetCurve& curve : onset.curves) {
        const double rod = curve.rod_fraction, exact = 0.5 - 3.75 * rod;
        if (exact <= 0.2) continue;
        ASSERT_EQ(curve.crossings[0].all.size(), 1u);
        const Crossing& mean = curve.crossings[0].all[0];
        EXPECT_NEAR(mean.bead_fraction, exact, 1e-9) << rod;
        EXPECT_NEAR(0.5 * (mean.low + mean.high), exact, 0.2 * (mean.high - mean.low));
        EXPECT_NEAR(curve.threshold.front().value, (0.3 - 0.5 * rod) / 0.1, 1e-9);
        EXPECT_NEAR(curve.alignment.front(), 2.0 * (0.1 * (1.8 + 10.0 * rod) + 0.5 * rod) / 0.3, 1e-9);
    }
}

TEST(Onset, does_not_exist_for_rods_that_turn_away_from_the_flow) {
    Table table = straight_table();
    for (TableEntry& entry : table.rows[2].entries) entry.value = -0.1;
    for (const OnsetCurve& curve : find_onset(table).curves)
        for (const Crossings& found : curve.crossings) {
            EXPECT_TRUE(found.all.empty());
            EXPECT_FALSE(found.above_all);
            EXPECT_EQ(found.any, 0.0);
        }
}

TEST(Onset, names_what_is_missing_in_the_table) {
    Table table = straight_table();
    table.rows.pop_back();
    EXPECT_NE(refusal_of([&] { find_onset(table); }).find("weathercock"), std::string::npos);
    table = straight_table();
    table.rows[0].entries[2] = {.value = NAN, .error = NAN, .origin = Origin::missing, .remark = "rods jam"};
    EXPECT_NE(refusal_of([&] { find_onset(table); }).find("drag at bead area fraction 0.2, rod area fraction 0.11"),
              std::string::npos);
    table = straight_table();
    table.bead_fractions = {0.2};
    EXPECT_NE(refusal_of([&] { find_onset(table); }).find("a boundary needs at least two"), std::string::npos);
}

}  // namespace
}  // namespace drover::calibrate::onset_tests
