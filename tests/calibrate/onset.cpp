// tests/calibrate/onset.cpp: predicted flocking thresholds of tables with known crossings.
#include "drover/calibrate/onset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/refusal.hpp"
#include "calibrate/closures.hpp"
#include "drover/calibrate/field_model.hpp"

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
    ASSERT_EQ(onset.line.size(), 21u);
    EXPECT_EQ(onset.bead_fractions.size(), 31u);
    for (const OnsetCurve& point : onset.line) {
        // 1 + 4 Phi_b + 10 Phi_r = 3; with lambda_s for lambda 1.5, which this table exceeds at its first node.
        const double exact = 0.5 - 2.5 * point.rod_fraction;
        const Crossing& mean = point.crossings[0];
        EXPECT_NEAR(mean.bead_fraction, exact, 1e-9) << point.rod_fraction;
        EXPECT_EQ(mean.share, 1.0);
        EXPECT_TRUE(std::isnan(point.crossings[1].bead_fraction));
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
        const Crossing& mean = curve.crossings[0];
        const double expected = drag.at(mean.bead_fraction, curve.rod_fraction).error / 4.0;
        // The spread of 400 redrawn tables is known to 3.5 %; the slope of the curve varies by a few percent.
        EXPECT_NEAR(mean.error, expected, 0.15 * expected) << curve.rod_fraction;
    }
    EXPECT_EQ(find_onset(table).line[3].crossings[0].error, onset.line[3].crossings[0].error);  // drawn by counter
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
    const Crossing crossing = find_onset(table).curves[0].crossings[0];
    EXPECT_NEAR(crossing.bead_fraction, 0.5, 1e-6);            // a node: c is exact there
    EXPECT_NEAR(crossing.error, 0.1 / 4.0, 0.15 * 0.1 / 4.0);  // 400 tables: 3.5 %; c and lambda are not straight lines
    const Uncertain g = mean_field(table, {.bead_fraction = 0.5, .rod_fraction = 0.08}).alignment;
    EXPECT_NEAR(g.value, 2.0, 1e-9);
    EXPECT_NEAR(g.error, 0.1, 0.02);  // half the distance of two quantiles of 200: 7 %
    const Uncertain w =
        field_number(table, "advection.strength", {.bead_fraction = 0.5, .rod_fraction = 0.08}, OrderKind::orientation)
            .number;
    EXPECT_NEAR(w.value, 3.0 / 16.0 * 2.0 * 3.0, 1e-9);
    EXPECT_NEAR(w.error, 3.0 / 16.0 * 0.1 * 3.0, 0.2 * 3.0 / 16.0 * 0.1 * 3.0);
}

TEST(Onset, gives_the_fraction_of_redrawn_tables_with_a_crossing) {
    // 3 mm/s at the last node: half of the redrawn tables reach it.
    Table table = straight_table();
    for (TableRow& row : table.rows)
        if (row.name == "drag")
            for (TableEntry& entry : row.entries) entry.value -= 0.9 + 1e-6;
    const Crossing crossing = find_onset(table).curves[0].crossings[0];  // 0.1 + 4 Phi_b + 0.5 < 3 up to 0.6...
    EXPECT_NEAR(crossing.bead_fraction, 0.6 + 2.5e-7, 1e-6);
    for (TableRow& row : table.rows)
        if (row.name == "drag")
            for (TableEntry& entry : row.entries) entry.value -= 0.4;
    const Crossing edge = find_onset(table).curves[0].crossings[0];
    EXPECT_TRUE(std::isnan(edge.bead_fraction));
    EXPECT_FALSE(edge.above_all);
    EXPECT_TRUE(std::isnan(edge.error));
    // About a half, with a standard deviation of 2.5 % for 400 tables; some cross before the last node and fall back.
    EXPECT_NEAR(edge.share, 0.5, 0.1);
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
        const Crossing& mean = curve.crossings[0];
        EXPECT_NEAR(mean.bead_fraction, exact, 1e-9) << rod;
        // Of normal errors, 16 and 84 % are one standard deviation apart from the median; 400 tables.
        EXPECT_NEAR(mean.quantiles[1], exact, 0.2 * mean.error);
        EXPECT_NEAR(mean.quantiles[2] - mean.quantiles[0], 2.0 * mean.error, 0.3 * mean.error);
        EXPECT_NEAR(curve.threshold.front().value, (0.3 - 0.5 * rod) / 0.1, 1e-9);
        EXPECT_NEAR(curve.alignment.front(), 2.0 * (0.1 * (1.8 + 10.0 * rod) + 0.5 * rod) / 0.3, 1e-9);
    }
}

TEST(Onset, does_not_exist_for_rods_that_turn_away_from_the_flow) {
    Table table = straight_table();
    for (TableEntry& entry : table.rows[2].entries) entry.value = -0.1;
    for (const OnsetCurve& curve : find_onset(table).curves)
        for (const Crossing& crossing : curve.crossings) {
            EXPECT_TRUE(std::isnan(crossing.bead_fraction));
            EXPECT_FALSE(crossing.above_all);
            EXPECT_EQ(crossing.share, 0.0);
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
