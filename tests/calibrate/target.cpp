// tests/calibrate/target.cpp: errors of wanted numbers from redrawn measurements, and the choice of further trials.
#include "calibrate/target.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "base/refusal.hpp"

namespace drover::calibrate::target_tests {
namespace {

/// alpha/Gamma = 1 + 4 Phi_b, a = 0.3, lambda = 0.1: flocks from Phi_b = 0.5, where the slope of alpha/Gamma is 4.
Table straight_table() {
    Table table{.varied_key = {},
                .bead_fractions = {0.2, 0.3, 0.4, 0.5, 0.6, 0.7},
                .rod_fractions = {0.05},
                .rows = {}};
    for (const auto& [name, by_rods] : {std::pair{"drag", true}, std::pair{"relaxation_rate", false},
                                        std::pair{"weathercock", false}, std::pair{"rod_area", false}}) {
        TableRow row{.name = name, .unit = "x", .formula = "x", .by_rods = by_rods};
        for (const double bead : table.bead_fractions)
            row.entries.push_back({.value = row.name == "drag"              ? 1.0 + 4.0 * bead
                                            : row.name == "relaxation_rate" ? 0.3
                                            : row.name == "weathercock"     ? 0.1
                                                                            : 4.0,
                                   .error = 0.01,
                                   .origin = row.name == "rod_area" ? Origin::set : Origin::measured});
        table.rows.push_back(row);
    }
    return table;
}

/// Errors of these entries; all others have none.
Table with_errors(Table table, const std::vector<std::tuple<const char*, std::size_t, double>>& errors) {
    for (TableRow& row : table.rows)
        for (TableEntry& entry : row.entries) entry.error = 0.0;
    for (const auto& [name, entry, error] : errors)
        std::ranges::find(table.rows, name, &TableRow::name)->entries[entry].error = error;
    return table;
}

TEST(TableTarget, has_the_value_of_the_table_where_the_flow_bends) {
    Table table = straight_table();
    const auto add = [&](const char* name, auto value) {
        TableRow row{.name = name, .unit = "1", .formula = "x", .by_rods = true};
        for (const double bead : table.bead_fractions)
            row.entries.push_back({.value = value(bead), .error = 0.1, .origin = Origin::measured});
        table.rows.push_back(row);
    };
    add("alignment_steady", [](double bead) { return 2.0 + 4.0 * bead; });
    add("alignment_drift", [](double) { return 0.0; });
    add("alignment_reference", [](double bead) { return 2.0 + 4.0 * bead; });
    add("drag_straight", [](double bead) { return 1.5 + 4.0 * bead; });  // 0.5 above the slope at P = 0
    Table derived = table;
    add_derived(derived);
    const TableTarget target{.row = "alignment", .bead = 2, .error = 0.1};
    // Without any error they would have no weight in c.
    const Table uncertain =
        with_errors(table, {{"drag", 2, 0.04}, {"alignment_steady", 2, 1e-6}, {"alignment_reference", 2, 1e-6}});
    const TargetResult found = evaluate({target}, uncertain, {{{"drag", 2}}})[0];
    // The straight line leaves c; the slope at P = 0 then gives a smaller g than that of the flock, 2 + 4 Phi_b.
    EXPECT_NEAR(found.value, 2.0 + 4.0 * 0.4 - 2.0 * 0.1 * 0.5 / 0.3, 1e-9);
    EXPECT_NEAR(find_row(derived, "alignment")->entries[2].value, found.value, 1e-9);
    EXPECT_NEAR(found.error, 2.0 * 0.1 * 0.04 / 0.3, 0.01 * 2.0 * 0.1 * 0.04 / 0.3);  // c does not follow from drag
}

TEST(TableTarget, of_an_onset_has_the_errors_of_the_measurements_next_to_it) {
    std::vector<Source> sources;
    Table table = with_errors(straight_table(), {});
    for (std::size_t bead = 0; bead < 6; ++bead) {
        table.rows[0].entries[bead].error = 0.04;
        table.rows[1].entries[bead].error = 0.002;
        sources.push_back({{"drag", bead}});
        sources.push_back({{"relaxation_rate", bead}});
    }
    const TargetResult onset = evaluate({{.error = 0.02}}, table, sources)[0];
    EXPECT_NEAR(onset.value, 0.5, 1e-9);
    // At a node: 0.04/4 by the drag and 0.002/(0.1 4) by the relaxation; 400 draws know an error by quantiles to 6 %.
    EXPECT_NEAR(onset.error, std::hypot(0.01, 0.005), 0.15 * std::hypot(0.01, 0.005));
    EXPECT_NEAR(onset.allowed, 0.02 * onset.quantiles[1], 1e-12);
    EXPECT_NEAR(onset.parts[6], 0.8, 0.1);  // the drag at Phi_b = 0.5
    EXPECT_NEAR(onset.parts[7], 0.2, 0.1);
    EXPECT_NEAR(onset.parts[0] + onset.parts[1], 0.0, 1e-3);  // Phi_b = 0.2 does not matter
    EXPECT_NEAR(std::accumulate(onset.parts.begin(), onset.parts.end(), 0.0), 1.0, 1e-12);
}

TEST(TableTarget, keeps_what_two_inputs_share) {
    // Contacts from rods that also align by the flow: c sigma contains -lambda alpha/Gamma, so lambda cancels at the
    // only area fraction of rods.
    Table table = straight_table();
    for (const auto& [name, value] :
         {std::pair{"alignment_steady", 1.5}, std::pair{"alignment_drift", 0.0}, std::pair{"alignment_reference", 1.5}})
        table.rows.push_back(
            {.name = name,
             .unit = "1",
             .formula = "x",
             .by_rods = true,
             .entries = std::vector<TableEntry>(6, {.value = value, .error = 0.0, .origin = Origin::measured})});
    for (std::size_t bead = 0; bead < 6; ++bead)
        table.rows[4].entries[bead].value = 1.0 + 2.0 * table.bead_fractions[bead];  // g = 2 at Phi_b = 0.5
    std::vector<Source> sources;
    for (std::size_t bead = 0; bead < 6; ++bead) {
        for (const std::size_t row : {2, 4, 6})
            table.rows[row].entries[bead].error = 0.02;  // lambda, g at 1/a = 0, 10 s
        sources.push_back({{"weathercock", bead}});
        sources.push_back({{"alignment_steady", bead}});
    }
    const TargetResult onset = evaluate({{.error = 0.02}}, table, sources)[0];
    EXPECT_NEAR(onset.value, 0.5, 1e-9);
    double by_weathercock = 0.0;
    for (std::size_t s = 0; s < sources.size(); s += 2) by_weathercock += onset.parts[s];
    EXPECT_LT(by_weathercock, 1e-9);
    EXPECT_NEAR(onset.error, 0.01, 0.0015);  // 0.02/2; 400 draws
}

// Two area fractions of rods with c = 4 +- 0.4 and 5.6 +- 0.4, chi^2 = 8: of the variance of c, which is 8 times that
// of the mean, 7 parts are what they disagree by.
TEST(TableTarget, knows_what_measurements_of_contacts_disagree_by) {
    Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {0.1, 0.2}, .rows = {}};
    const auto add = [&](const char* name, bool by_rods, std::vector<double> values, std::vector<double> errors) {
        TableRow& row = table.rows.emplace_back(TableRow{.name = name, .by_rods = by_rods});
        for (std::size_t i = 0; i < values.size(); ++i)
            row.entries.push_back({.value = values[i], .error = errors[i], .trials = 16, .origin = Origin::measured});
    };
    add("relaxation_rate", false, {0.1}, {0.0});
    add("rod_area", false, {4.0}, {0.0});
    table.rows.back().entries[0].origin = Origin::set;
    add("contact_steady", true, {0.1, 0.28}, {0.01, 0.02});
    add("contact_slope", true, {0.0, 0.0}, {0.0, 0.0});
    add("contact_reference", true, {0.1, 0.28}, {0.01, 0.02});
    const std::vector<TargetResult> found = evaluate({{.row = "contact_alignment", .error = 0.1}}, table,
                                                     {{{"contact_steady", 0}}, {{"contact_steady", 1}}});
    EXPECT_NEAR(found[0].disagreement, 7.0 / 8.0, 0.01);  // draws have a variance of 1 to 1 %
    EXPECT_NEAR(found[0].parts[0], 1.0 / 16.0, 0.01);
    EXPECT_NEAR(found[0].error, 0.4 * std::sqrt(4.0), 0.15 * 0.8);  // 400 draws
}

TEST(TableTarget, of_an_onset_beyond_the_table_says_so) {
    Table table = straight_table();
    for (TableEntry& entry : table.rows[0].entries) entry.value -= 1.0;  // reaches 2.8 of 3 mm/s
    const auto with_error = [&](double error) {
        return evaluate({{.error = 0.02}}, with_errors(table, {{"drag", 5, error}}), {{{"drag", 5}}})[0];
    };
    const TargetResult clear = with_error(0.05), open = with_error(0.3);
    EXPECT_EQ(clear.value, INFINITY);
    EXPECT_TRUE(clear.is_beyond);
    EXPECT_FALSE(open.is_beyond);
    EXPECT_TRUE(std::isinf(open.error));
    EXPECT_NEAR(open.parts[0], 1.0, 1e-12);
}

TEST(TableTarget, of_a_coefficient_is_its_entry) {
    const TargetResult drag = evaluate({{.row = "drag", .bead = 2, .error = 0.1, .is_relative = false}},
                                       with_errors(straight_table(), {{"drag", 2, 0.04}}), {{{"drag", 2}}})[0];
    EXPECT_NEAR(drag.value, 2.6, 1e-12);
    EXPECT_NEAR(drag.error, 0.04, 1e-4);  // the middles of 400 parts, and the value itself
    EXPECT_EQ(drag.allowed, 0.1);
}

TEST(TableTarget, needs_the_rows_of_its_formula) {
    const std::vector<std::string> all{"drag", "relaxation_rate", "weathercock", "propulsion"};
    EXPECT_EQ(inputs_of({}, all).size(), 3u);
    EXPECT_EQ(inputs_of({.row = "propulsion"}, all), std::vector<std::string>{"propulsion"});
    EXPECT_NE(refusal_of([&] { inputs_of({.row = "alignmnt"}, all); }).find("did you mean alignment?"),
              std::string::npos);
    // drag_cubic is zero where it is not measured.
    const std::vector<std::string> straight{"drag", "relaxation_rate", "weathercock", "propulsion"};
    EXPECT_EQ(inputs_of({.row = "relaxation_saturation"}, straight).size(), 4u);
    EXPECT_NE(refusal_of([&] { inputs_of({}, {"drag"}); }).find("add its assay to calibrate.assays"),
              std::string::npos);
}

TEST(Allocation, gives_trials_as_deviation_over_the_root_of_the_cost) {
    // Neyman: standard deviations 4, 2, 2 and costs 1, 1, 4 give 4 : 2 : 1.  Variances are of 10 trials.
    const std::vector<std::size_t> added =
        allocate({{.trials = 10, .max_trials = 100000, .seconds = 1.0, .variances = {160.0}},
                  {.trials = 10, .max_trials = 100000, .seconds = 1.0, .variances = {40.0}},
                  {.trials = 10, .max_trials = 100000, .seconds = 4.0, .variances = {40.0}}},
                 INFINITY);
    const double first = static_cast<double>(added[0] + 10), second = static_cast<double>(added[1] + 10),
                 third = static_cast<double>(added[2] + 10);
    EXPECT_NEAR(first / second, 2.0, 0.02);  // whole trials
    EXPECT_NEAR(second / third, 2.0, 0.02);
    EXPECT_NEAR(1600.0 / first + 400.0 / second + 400.0 / third, 1.0, 0.01);  // the variance that is allowed
}

TEST(Allocation, respects_limits_and_gives_nothing_to_targets_that_are_reached) {
    const std::vector<std::size_t> added =
        allocate({{.trials = 10, .max_trials = 12, .seconds = 1.0, .variances = {9.0, 0.0}},
                  {.trials = 10, .max_trials = 100, .seconds = 1.0, .variances = {0.0, 0.9}}},
                 INFINITY);
    EXPECT_EQ(added, (std::vector<std::size_t>{2, 0}));
    EXPECT_EQ(allocate({{.trials = 10, .max_trials = 100, .seconds = 2.0, .variances = {9.0}}}, 7.0),
              (std::vector<std::size_t>{4}));
}

}  // namespace
}  // namespace drover::calibrate::target_tests
