// tests/calibrate/table.cpp: closures and smooth coefficients with their errors, and checks of tables.
#include "calibrate/table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/refusal.hpp"
#include "calibrate/alignment.hpp"
#include "calibrate/field_model.hpp"
#include "calibrate/setup_rows.hpp"

namespace drover::calibrate::table_tests {
namespace {

TableRow row_of(const std::string& name, bool by_rods, const std::vector<double>& values, double relative_error,
                Origin origin = Origin::measured) {
    TableRow row{.name = name, .unit = "1", .formula = "x", .by_rods = by_rods};
    for (const double value : values)
        row.entries.push_back({.value = value, .error = relative_error * value, .trials = 32, .origin = origin});
    return row;
}

/// Two by two points.
Table small_table() {
    Table table{.varied_key = {}, .bead_fractions = {0.2, 0.4}, .rod_fractions = {0.05, 0.1}, .rows = {}};
    table.rows = {row_of("relaxation_rate", false, {0.4, 0.2}, 0.03),
                  row_of("weathercock", false, {0.1, 0.05}, 0.04),
                  row_of("propulsion", false, {3.0, 2.0}, 0.02),
                  row_of("damping_rate", false, {20.0, 20.0}, 0.01),
                  row_of("response_time", true, {0.1, 0.1, 0.1, 0.05}, 0.06),
                  row_of("viscosity_kinematic", false, {5.0, 10.0}, 0.1),
                  row_of("drag", true, {1.0, 1.5, 2.0, 2.5}, 0.05),
                  row_of("bead_mass", false, {0.75, 0.75}, 0.0, Origin::set),
                  row_of("bead_area", false, {0.5, 0.5}, 0.0, Origin::set),
                  row_of("rod_area", false, {5.0, 5.0}, 0.0, Origin::set)};
    return table;
}

const TableEntry& entry_at(const Table& table, const std::string& name, std::size_t bead, std::size_t rod) {
    const TableRow* row = find_row(table, name);
    if (row == nullptr) throw std::runtime_error("no row " + name);
    return row->entries[entry_index(table, *row, 0, bead, rod)];
}

// g = g_flow + g_contacts, and contacts are what the total of the drag assay leaves after the flow: at one area
// fraction of rods the flow cancels, and g is that total, g_0 + g_1/a.
TEST(CalibrationTable, counts_the_error_of_the_flow_once_in_the_alignment) {
    Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {0.1}, .rows = {}};
    const double a = 0.1, e_a = 0.005, e_0 = 0.1, drift = 0.05, e_1 = 0.01, reference = 10.0;
    const auto add = [&](const char* name, double value, double error) {
        table.rows.push_back(row_of(name, std::string(name) == "drag", {value}, error / value));
    };
    add("relaxation_rate", a, e_a);
    add("weathercock", 0.02, 0.004);
    add("drag", 2.0, 0.2);
    add("propulsion", 3.0, 0.1);
    add("rod_area", 4.0, 0.0);
    for (const auto& [name, value, error] : {std::tuple{"alignment_steady", 1.5, e_0},
                                             {"alignment_drift", drift, e_1},
                                             {"alignment_reference", 2.0, std::hypot(e_0, reference * e_1)}})
        table.rows.push_back(row_of(name, true, {value}, error / value));
    Table sure = table;
    for (const std::size_t flow : {1, 2}) sure.rows[flow].entries[0].error = 0.0;
    for (Table* one : {&table, &sure}) add_derived(*one);
    const TableEntry& g = entry_at(table, "alignment", 0, 0);
    const double error = std::hypot(e_0, e_1 / a, drift / (a * a) * e_a);
    EXPECT_NEAR(g.value, 1.5 + drift / a, 1e-12);
    EXPECT_NEAR(g.error, error, 0.15 * error);  // a half width of 400 draws is known to 5 %
    EXPECT_NEAR(g.error, entry_at(sure, "alignment", 0, 0).error, 1e-12);
    const TableEntry& w = entry_at(table, "advection", 0, 0);  // 3 g/(16 sigma)
    EXPECT_NEAR(w.error / w.value, g.error / g.value, 1e-12);
}

// alpha/Gamma and tau of one assay, of which one falls where the other rises: alpha = (alpha/Gamma) m rho/tau.
TEST(CalibrationTable, keeps_what_rows_share_that_come_from_the_same_trials) {
    const auto relative_error = [](double sign, std::size_t resamples) {
        Table table = small_table();
        TableEntry &time = table.rows[4].entries[3], &drag = table.rows[6].entries[3];
        for (std::size_t k = 0; k < resamples; ++k) {
            time.ranks.push_back(static_cast<double>(37 * k % resamples));
            drag.ranks.push_back(sign * time.ranks.back());
        }
        drag.error = 0.06 * drag.value;  // as that of tau
        add_derived(table);
        const TableEntry& found = entry_at(table, "driving_strength", 1, 1);
        return found.error / found.value;
    };
    // u alone is left, 2 %; a sine of 12 %.  The quantile of 400 draws lies between two that are 1 % apart.
    EXPECT_NEAR(relative_error(1.0, 400), 0.02, 0.15 * 0.02);
    EXPECT_NEAR(relative_error(-1.0, 400), std::hypot(0.02, 0.12), 0.05 * 0.12);
    EXPECT_NEAR(relative_error(1.0, 0), std::hypot(0.02, 0.06, 0.06), 0.15 * 0.09);  // known to 5 %
}

// The alignment assay gives c sigma at a, contact_steady + a contact_slope, and the error of that at a = 0.1/s, which
// tells how both vary together.
TEST(CalibrationTable, has_the_error_of_a_line_at_the_rate_of_rods) {
    for (const double correlation : {-0.95, 0.0, 0.95}) {
        Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {0.1}, .rows = {}};
        const double a = 0.3, e_0 = 0.02, e_1 = 0.1;
        const auto error_at = [&](double rate) {
            return std::sqrt(e_0 * e_0 + rate * rate * e_1 * e_1 + 2.0 * rate * correlation * e_0 * e_1);
        };
        for (const auto& [name, by_rods, value, error] : {std::tuple{"relaxation_rate", false, a, 0.0},
                                                          {"rod_area", false, 4.0, 0.0},
                                                          {"contact_steady", true, 0.1, e_0},
                                                          {"contact_slope", true, 0.5, e_1},
                                                          {"contact_reference", true, 0.15, error_at(0.1)}})
            table.rows.push_back(row_of(name, by_rods, {value}, error / value));
        add_derived(table);
        const TableEntry& c = entry_at(table, "contact_alignment", 0, 0);
        const double sigma = 0.1 / 4.0;
        EXPECT_NEAR(c.value, (0.1 + a * 0.5) / sigma, 1e-12);
        EXPECT_NEAR(c.error, error_at(a) / sigma, 0.15 * error_at(a) / sigma) << correlation;
    }
}

// Two area fractions of rods that disagree by chi^2 = 8: the error grows by sqrt(8).
TEST(CalibrationTable, has_a_larger_error_of_contacts_where_measurements_disagree) {
    Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {0.1, 0.2}, .rows = {}};
    table.rows = {row_of("relaxation_rate", false, {0.1}, 0.0), row_of("rod_area", false, {4.0}, 0.0)};
    for (const char* name : {"contact_steady", "contact_slope", "contact_reference"}) {
        table.rows.push_back(row_of(name, true, {0.1, 0.2}, 0.0));
        for (TableEntry& entry : table.rows.back().entries) entry.value *= table.rows.size() == 4 ? 0.0 : 1.0;
    }
    for (const std::size_t row : {2, 4}) {
        table.rows[row].entries[0].error = 0.01;  // c = 4 +- 0.4
        table.rows[row].entries[1].error = 0.02;  // c = 5.6 +- 0.4
        table.rows[row].entries[1].value = 0.28;
    }
    add_derived(table);
    const TableEntry& c = entry_at(table, "contact_alignment", 0, 0);
    const double error = 0.4 / std::sqrt(2.0) * std::sqrt(8.0);
    EXPECT_NEAR(c.value, 4.8, 1e-12);
    EXPECT_NEAR(c.error, error, 0.15 * error);  // 400 draws
}

TEST(CalibrationTable, has_the_closures_of_independent_rods_with_their_errors) {
    Table table = small_table();
    add_derived(table);
    const double a = 0.2, single = 0.1, u = 2.0, drag = 2.5, sigma = 0.1 / 5.0, g = single * drag / a;
    struct Expected {
        const char* name;
        double value, relative_error;
        Origin origin;
    };
    const double e_a = 0.03, e_l = 0.04, e_u = 0.02, e_g = 0.01, e_t = 0.06, e_d = 0.05;
    for (const Expected& expected :
         {Expected{"noise_order", a * sigma * u * u, std::hypot(e_a, 2 * e_u), Origin::closure},
          {"pressure_rods", u * u / 2, 2 * e_u, Origin::closure},
          {"elasticity_stiffness", u * u / (16 * a), std::hypot(2 * e_u, e_a), Origin::closure},
          {"relaxation_saturation", a * g * g / (8 * sigma * sigma * u * u),
           std::sqrt(4 * e_l * e_l + 4 * e_d * e_d + e_a * e_a + 4 * e_u * e_u), Origin::closure},
          {"advection", 3.0 / 16.0 * g / sigma, std::sqrt(e_l * e_l + e_d * e_d + e_a * e_a), Origin::closure},
          {"alignment", g, std::sqrt(e_l * e_l + e_d * e_d + e_a * e_a), Origin::measured},
          {"relaxation_over_weathercock", a / 0.05, std::hypot(e_a, e_l), Origin::measured},
          {"friction", 0.6 / 0.05, e_t, Origin::measured},
          {"friction_of_plates", 20.0 * 0.6, e_g, Origin::measured},
          {"driving_strength", drag * 12.0 / (sigma * u), std::sqrt(e_d * e_d + e_t * e_t + e_u * e_u),
           Origin::measured},
          {"weathercock_strength", 0.05 * sigma * u, std::hypot(e_l, e_u), Origin::measured}}) {
        const TableEntry& found = entry_at(table, expected.name, 1, 1);
        EXPECT_NEAR(found.value, expected.value, 1e-12 * expected.value) << expected.name;
        // In quadrature but for the curvature of formulas; a half width of 400 draws is known to 5 %.
        EXPECT_NEAR(found.error / expected.value, expected.relative_error, 0.15 * expected.relative_error)
            << expected.name;
        EXPECT_EQ(found.origin, expected.origin) << expected.name;
        EXPECT_EQ(found.trials, 32) << expected.name;
    }
    for (const char* zero : {"pressure_beads", "stiffness", "stiffness_rods", "viscosity_bulk"}) {
        EXPECT_EQ(entry_at(table, zero, 0, 0).value, 0.0);
        EXPECT_EQ(entry_at(table, zero, 0, 0).origin, Origin::set);
    }
    EXPECT_EQ(entry_at(table, "elasticity_splay", 0, 0).origin, Origin::closure);
    EXPECT_FALSE(find_row(table, "elasticity_stiffness")->by_rods);
    EXPECT_TRUE(find_row(table, "noise_order")->by_rods);
    check(table);
}

TEST(CalibrationTable, has_the_saturation_that_gives_the_mean_field_order) {
    Table table = small_table();
    for (TableEntry& entry : table.rows[1].entries) entry.value *= 4.0;
    add_derived(table);
    const double lambda = 0.2, drag = 2.5, a = 0.2, current = 0.02 * 2.0 * order_of_alignment(2.0 * lambda * drag / a);
    ASSERT_GT(current, 0.0);
    const double b = entry_at(table, "relaxation_saturation", 1, 1).value;
    EXPECT_NEAR(a - lambda * drag + b * current * current, 0.0, 1e-12);
}

TEST(CalibrationTable, replaces_a_response_time_that_is_not_resolved_by_its_error) {
    Table table = small_table();
    table.rows[4].entries[3] = {.value = -0.01, .error = 0.04, .trials = 32, .origin = Origin::measured};
    add_derived(table);
    const TableEntry& friction = entry_at(table, "friction", 1, 1);
    EXPECT_NEAR(friction.value, 0.6 / 0.04, 1e-12);
    // The logarithm of tau has an error of 1; 400 parts of equal probability are straight between their middles to 1 %.
    EXPECT_NEAR(friction.error, std::sinh(1.0) * friction.value, 0.01 * friction.value);
    EXPECT_EQ(friction.origin, Origin::closure);
    EXPECT_EQ(friction.remark, "response_time = -0.01 +- 0.04: replaced by its error");
    const FieldNumber number =
        field_number(table, "drag.coefficient", {.bead_fraction = 0.4, .rod_fraction = 0.1}, OrderKind::orientation);
    EXPECT_EQ(number.number.value, friction.value);
    EXPECT_EQ(number.number.error, friction.error);
    EXPECT_EQ(number.origin, Origin::closure);
    EXPECT_EQ(entry_at(table, "friction", 1, 0).origin, Origin::measured);
}

TEST(CalibrationTable, has_no_entry_where_an_input_is_missing_or_a_divisor_may_be_zero) {
    Table table = small_table();
    table.rows[0].entries[0] = {.value = 0.4, .error = 0.2, .trials = 32, .origin = Origin::measured_short};
    table.rows[6].entries[3] = {.value = NAN, .error = NAN, .origin = Origin::missing, .remark = "no"};
    add_derived(table);
    EXPECT_EQ(entry_at(table, "elasticity_stiffness", 0, 0).origin, Origin::missing);
    EXPECT_NE(entry_at(table, "elasticity_stiffness", 0, 0).remark.find("not significantly different from 0"),
              std::string::npos);
    EXPECT_EQ(entry_at(table, "noise_order", 0, 0).origin, Origin::closure);  // not a divisor
    EXPECT_EQ(entry_at(table, "relaxation_over_weathercock", 0, 0).origin, Origin::measured_short);
    EXPECT_EQ(entry_at(table, "alignment", 1, 1).remark, "drag is missing");
    EXPECT_EQ(entry_at(table, "alignment", 1, 0).origin, Origin::measured);
    check(table);  // missing entries are valid
}

TEST(CalibrationTable, has_no_rows_without_their_inputs) {
    Table table = small_table();
    std::erase_if(table.rows, [](const TableRow& row) { return row.name == "propulsion"; });
    add_derived(table);
    EXPECT_EQ(find_row(table, "noise_order"), nullptr);
    EXPECT_NE(find_row(table, "alignment"), nullptr);
}

TEST(CalibrationTable, is_rejected_with_negative_errors_descending_axes_or_missing_numbers) {
    const auto why_no_error = [](const std::function<void(Table&)>& spoil) {
        Table table = small_table();
        spoil(table);
        return refusal_of([&] { check(table, {.file = "rods.h5"}); });
    };
    EXPECT_EQ(why_no_error([](Table& t) { t.rows[6].entries[1].error = -0.1; }),
              "rods.h5: drag at bead area fraction 0.2, rod area fraction 0.1 has the standard error -0.1; expected a "
              "number >= 0");
    EXPECT_EQ(
        why_no_error([](Table& t) { t.rows[0].entries[1].value = NAN; }),
        "rods.h5: relaxation_rate at bead area fraction 0.4 is nan; expected a finite number, since its origin is "
        "not \"missing\"");
    EXPECT_EQ(why_no_error([](Table& t) {
                  t.bead_fractions = {0.4, 0.2};
              }),
              "rods.h5: bead_area_fraction: value 2 is 0.2; expected ascending area fractions between 0 and 1");
    EXPECT_EQ(why_no_error([](Table& t) { t.rows[6].entries.pop_back(); }), "rods.h5: drag has 3 numbers; expected 4");
    EXPECT_EQ(why_no_error([](Table& t) { t.bead_fractions.clear(); }),
              "rods.h5: bead_area_fraction is empty; expected at least one value");
}

/// Four by three points with different errors.
Table larger_table() {
    Table table{.varied_key = {},
                .bead_fractions = {0.2, 0.3, 0.5, 0.7},
                .rod_fractions = {0.05, 0.08, 0.11},
                .rows = {}};
    TableRow row{.name = "drag", .unit = "mm/s", .formula = "x", .by_rods = true};
    for (std::size_t i = 0; i < 12; ++i)
        row.entries.push_back({.value = 1.0 + std::sin(1.0 + static_cast<double>(i)),
                               .error = 0.02 + 0.01 * static_cast<double>(i % 5),
                               .origin = Origin::measured});
    table.rows = {row, row_of("weathercock", false, {0.1, 0.12, 0.15, 0.2}, 0.1)};
    return table;
}

TEST(SmoothCoefficient, has_the_exact_error_of_interpolation_between_uncertain_nodes) {
    const Table table = larger_table();
    const SmoothCoefficient smooth(table, "drag");
    for (const auto& [bead, rod] : {std::pair{0.2, 0.05}, {0.3, 0.11}, {0.25, 0.06}, {0.61, 0.1}, {0.7, 0.07}}) {
        const Uncertain found = smooth.at(bead, rod);
        double squares = 0.0;  // the value is linear in the nodes: shift each by its error in turn
        for (std::size_t k = 0; k < 12; ++k) {
            Table shifted = table;
            shifted.rows[0].entries[k].value += shifted.rows[0].entries[k].error;
            squares += std::pow(SmoothCoefficient(shifted, "drag").at(bead, rod).value - found.value, 2);
        }
        EXPECT_NEAR(found.error, std::sqrt(squares), 1e-12) << bead << ' ' << rod;
    }
    EXPECT_EQ(smooth.at(0.3, 0.11).value, table.rows[0].entries[5].value);
    EXPECT_NEAR(smooth.at(0.3, 0.11).error, table.rows[0].entries[5].error, 1e-15);
    EXPECT_LT(smooth.at(0.4, 0.08).error, 0.06);
}

TEST(SmoothCoefficient, of_beads_alone_accepts_any_area_fraction_of_rods) {
    const SmoothCoefficient smooth(larger_table(), "weathercock");
    EXPECT_EQ(smooth.at(0.5, 0.4).value, 0.15);
    EXPECT_NEAR(smooth.at(0.5, 0.4).error, 0.015, 1e-15);
}

TEST(SmoothCoefficient, extrapolates_only_on_request) {
    const Table table = larger_table();
    EXPECT_EQ(refusal_of([&] { SmoothCoefficient(table, "drag").at(0.75, 0.08); }),
              "drag at a bead area fraction of 0.75: the table covers 0.2 to 0.7; expected a value within it: measure "
              "there, or use the value at the edge (calibrated.outside = \"hold\" in the scene)");
    EXPECT_NE(refusal_of([&] { SmoothCoefficient(table, "drag").at(0.5, 0.2); }).find("rod area fraction of 0.2"),
              std::string::npos);
    const SmoothCoefficient held(table, "drag", 0, numerics::Outside::hold);
    EXPECT_EQ(held.at(0.9, 0.08).value, held.at(0.7, 0.08).value);
    EXPECT_EQ(held.at(0.9, 0.08).error, held.at(0.7, 0.08).error);
    // Rounding errors beyond an edge are tolerated.
    const SmoothCoefficient smooth(table, "drag");
    EXPECT_EQ(smooth.at(std::nextafter(0.7, 1.0), 0.08).value, smooth.at(0.7, 0.08).value);
}

TEST(SmoothCoefficient, rejects_missing_entries_and_unknown_names) {
    Table table = larger_table();
    table.rows[0].entries[4] = {.value = NAN, .error = NAN, .origin = Origin::missing, .remark = "rods jam"};
    EXPECT_EQ(
        refusal_of([&] { SmoothCoefficient(table, "drag"); }),
        "the table has no value of drag at bead area fraction 0.3, rod area fraction 0.08 (rods jam); expected values "
        "at all points: measure it, or remove this point from the scene");
    EXPECT_EQ(refusal_of([&] { SmoothCoefficient(table, "wethercock"); }),
              "the table has no coefficient wethercock; did you mean weathercock?");
    EXPECT_EQ(refusal_of([&] { SmoothCoefficient(table, "weathercock", 1); }),
              "index 1 of a key that the table does not vary is out of range; expected an index below 1");
}

TEST(SetupRows, say_that_whole_rods_cover_another_part_than_was_asked_for) {
    dem::Setup setup{.rods = {.area_fraction = 0.1}};
    for (const auto& [side, is_told] : {std::pair{13.5, true}, {90.0, false}}) {
        setup.cell.lx = setup.cell.ly = side;
        std::string remark;
        for (const SetupRow& row : setup_rows(setup)) remark += row.remark;
        // 4 of 4.4 rods in 13.5 mm; 194.5 of them in 90 mm.
        EXPECT_EQ(remark.starts_with("4 rods cover 0.09"), is_told) << remark;
        EXPECT_EQ(remark.empty(), !is_told) << remark;
    }
}

}  // namespace
}  // namespace drover::calibrate::table_tests
