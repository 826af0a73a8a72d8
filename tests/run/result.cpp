// tests/run/result.cpp: one description of a result as text and as the arrays of an archive.
#include "run/result.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace drover::run::result_tests {
namespace {

Entry number(const char* name, double value) {
    return {.name = name, .unit = "mm", .meaning = "a length", .value = value};
}

Record point(double x, double y) { return {.entries = {number("x", x), number("y", y)}}; }

/// Two lines of two and one points.
Result lines() {
    List list{.name = "lines", .row = "line"};
    for (const std::size_t count : {2u, 1u}) {
        List points{.name = "points", .row = "vertex", .meaning = "vertices", .group = "/boundary"};
        for (std::size_t i = 0; i < count; ++i) points.rows.push_back(point(static_cast<double>(i), 0.5));
        list.rows.push_back({.heading = "a line",
                             .entries = {{.name = "kind",
                                          .unit = "",
                                          .meaning = "kind",
                                          .value = std::string(count == 2 ? "open" : "closed"),
                                          .choices = {"open", "closed"}}},
                             .lists = {points}});
    }
    return {.root = {.group = "/plane", .entries = {number("width", 4.0)}, .lists = {list}}};
}

const files::ResultTable& table_of(const std::vector<files::ResultTable>& tables, const std::string& group) {
    return *std::find_if(tables.begin(), tables.end(), [&](const auto& table) { return table.group == group; });
}

std::vector<double> values_of(const files::ResultTable& table, const std::string& name) {
    for (std::size_t i = 0; i < table.quantities.size(); ++i)
        if (table.quantities[i].name == name) return table.values[i];
    ADD_FAILURE() << table.group << " has no " << name;
    return {};
}

TEST(ResultTables, of_nested_lists_repeat_the_entries_of_the_outer_list) {
    const std::vector<files::ResultTable> tables = result_tables(lines());
    ASSERT_EQ(tables.size(), 2u);
    const files::ResultTable& boundary = table_of(tables, "/boundary");
    ASSERT_EQ(boundary.axes.size(), 1u);
    EXPECT_EQ(boundary.axes[0].name, "vertex");
    EXPECT_EQ(values_of(boundary, "line"), (std::vector<double>{0.0, 0.0, 1.0}));
    EXPECT_EQ(values_of(boundary, "kind"), (std::vector<double>{0.0, 0.0, 1.0}));
    EXPECT_EQ(values_of(boundary, "x"), (std::vector<double>{0.0, 1.0, 0.0}));
    EXPECT_EQ(values_of(table_of(tables, "/plane"), "width"), std::vector<double>{4.0});
}

TEST(ResultTables, of_lists_with_coordinates_are_arrays_over_the_coordinates) {
    List outer{.name = "curves", .coordinate = "y"};
    for (const double y : {1.0, 2.0, 3.0}) {
        List inner{.name = "points", .group = "/curves", .coordinate = "x"};
        for (const double x : {10.0, 20.0})
            inner.rows.push_back({.entries = {number("x", x), number("product", x * y)}});
        outer.rows.push_back({.entries = {number("y", y)},
                              .parts = {{"single-rod", {.entries = {number("square", y * y)}}}},
                              .lists = {inner}});
    }
    const std::vector<files::ResultTable> tables = result_tables({.root = {.lists = {outer}}});
    ASSERT_EQ(tables.size(), 1u);
    ASSERT_EQ(tables[0].axes.size(), 2u);
    EXPECT_EQ(tables[0].axes[0].values, (std::vector<double>{1.0, 2.0, 3.0}));
    EXPECT_EQ(tables[0].axes[1].values, (std::vector<double>{10.0, 20.0}));
    EXPECT_EQ(values_of(tables[0], "product"), (std::vector<double>{10.0, 20.0, 20.0, 40.0, 30.0, 60.0}));
    EXPECT_EQ(values_of(tables[0], "single_rod_square"), (std::vector<double>{1.0, 4.0, 9.0}));
}

TEST(ResultAttributes, are_the_entries_of_a_root_without_group) {
    const Result result{.root = {.entries = {number("width", 4.0), number("missing", NAN)},
                                 .parts = {{"cell", {.entries = {number("side", 2.0)}}}}}};
    const std::vector<files::Attribute> attributes = result_attributes(result);
    ASSERT_EQ(attributes.size(), 2u);
    EXPECT_EQ(attributes[0].first, "width");
    EXPECT_EQ(attributes[1].first, "cell_side");
    EXPECT_TRUE(result_attributes(lines()).empty());
}

TEST(ResultText, has_values_with_unit_and_meaning_and_a_table_for_each_innermost_list) {
    EXPECT_EQ(result_text(lines()),
              "width  4 mm  a length\n"
              "\na line\n"
              "  kind: open\n"
              "    x [mm]  y [mm]\n"
              "         0     0.5\n"
              "         1     0.5\n"
              "\na line\n"
              "  kind: closed\n"
              "    x [mm]  y [mm]\n"
              "         0     0.5\n");
}

TEST(ResultText, omits_numbers_that_are_not_finite_and_shows_rounding_errors_in_tables_as_zero) {
    List list{.name = "modes"};
    list.rows = {point(1.0, NAN), point(1e-17, 2.0)};
    EXPECT_EQ(result_text({.root = {.entries = {number("width", NAN)}, .lists = {list}}}),
              "  x [mm]  y [mm]\n"
              "       1       -\n"
              "       0       2\n");
}

TEST(ResultText, of_different_quantities_keeps_numbers_far_below_the_largest) {
    List list{.name = "coefficients", .has_like_rows = false};
    list.rows = {{.entries = {words("value", "", 1e8)}}, {.entries = {words("value", "", 5e-6)}}};
    EXPECT_EQ(result_text({.root = {.lists = {list}}}),
              "  value\n"
              "  1e+08\n"
              "  5e-06\n");
}

TEST(ResultText, of_a_long_list_is_an_even_selection_with_both_ends) {
    List list{.name = "points", .max_rows = 3};
    for (int i = 0; i < 101; ++i) list.rows.push_back({.entries = {number("x", i)}});
    EXPECT_EQ(result_text({.root = {.lists = {list}}}), "  x [mm]\n       0\n      50\n     100\n");
}

}  // namespace
}  // namespace drover::run::result_tests
