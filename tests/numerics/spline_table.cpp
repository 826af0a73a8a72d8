// tests/numerics/spline_table.cpp: bicubic tables against functions that they reproduce.
#include "numerics/algebra/spline_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drover/base/error.hpp"

namespace drover::numerics::spline_table_tests {
namespace {

SplineTable table_of(double (*f)(double, double), Outside outside = Outside::refuse) {
    const std::vector<double> beads{0.2, 0.35, 0.4, 0.6, 0.7}, rods{0.05, 0.08, 0.11};
    std::vector<double> values;
    for (const double b : beads)
        for (const double r : rods) values.push_back(f(b, r));
    return {beads, rods, values, outside};
}

TEST(SplineTable, of_a_bilinear_function_is_that_function) {
    // Cubic splines with natural ends leave straight lines alone.
    const SplineTable table = table_of([](double b, double r) { return 1.0 + 2.0 * b - 3.0 * r + 4.0 * b * r; });
    for (const double b : {0.2, 0.27, 0.5, 0.7})
        for (const double r : {0.05, 0.1, 0.11}) {
            const TableValue d = table.at(b, r);
            EXPECT_NEAR(d.value, 1.0 + 2.0 * b - 3.0 * r + 4.0 * b * r, 1e-13);
            EXPECT_NEAR(d.by_first, 2.0 + 4.0 * r, 1e-12);
            EXPECT_NEAR(d.by_second, -3.0 + 4.0 * b, 1e-12);
        }
}

TEST(SplineTable, passes_through_its_nodes_and_its_slopes_are_those_of_its_values) {
    const auto f = [](double b, double r) { return std::sin(5.0 * b) * std::exp(10.0 * r); };
    const SplineTable table = table_of(f);
    EXPECT_NEAR(table.at(0.35, 0.08).value, f(0.35, 0.08), 1e-14);
    EXPECT_NEAR(table.at(0.7, 0.11).value, f(0.7, 0.11), 1e-14);
    for (const double b : {0.23, 0.35, 0.47, 0.62})
        for (const double r : {0.06, 0.08, 0.1}) {
            // Central differences: truncation 1e-12 times third derivatives of order 1e3 for rods, rounding 1e-16/1e-6.
            const double h = 1e-6, rounding = 1e-7;
            EXPECT_NEAR(table.at(b, r).by_first, (table.at(b + h, r).value - table.at(b - h, r).value) / (2 * h),
                        rounding);
            EXPECT_NEAR(table.at(b, r).by_second, (table.at(b, r + h).value - table.at(b, r - h).value) / (2 * h),
                        rounding);
        }
}

TEST(SplineTable, of_one_node_or_two_is_constant_or_straight) {
    const SplineTable constant({0.0}, {0.0}, {2.5}, Outside::refuse);
    EXPECT_EQ(constant.at(3.0, -1.0).value, 2.5);
    EXPECT_FALSE(constant.depends_on_first());
    const SplineTable line({0.0, 2.0}, {0.0}, {1.0, 5.0}, Outside::refuse);
    EXPECT_DOUBLE_EQ(line.at(0.5, 0.0).value, 2.0);
    EXPECT_DOUBLE_EQ(line.at(0.5, 0.0).by_first, 2.0);
}

TEST(SplineTable, outside_its_nodes_returns_nan_or_holds_the_edge_value) {
    const auto f = [](double b, double r) { return b + r; };
    EXPECT_TRUE(std::isnan(table_of(f).at(0.71, 0.08).value));
    EXPECT_TRUE(std::isnan(table_of(f).at(0.5, 0.04).value));
    const TableValue held = table_of(f, Outside::hold).at(0.9, 0.08);
    EXPECT_NEAR(held.value, 0.78, 1e-14);
    EXPECT_EQ(held.by_first, 0.0);
    EXPECT_NEAR(held.by_second, 1.0, 1e-12);
}

TEST(SplineTable, with_inconsistent_sizes_is_rejected) {
    EXPECT_THROW(SplineTable({0.0, 1.0}, {0.0}, {1.0}, Outside::refuse), Error);
    EXPECT_THROW(SplineTable({1.0, 1.0}, {0.0}, {1.0, 2.0}, Outside::refuse), Error);
    EXPECT_THROW(SplineTable({}, {0.0}, {}, Outside::refuse), Error);
    EXPECT_THROW(SplineTable({0.0}, {0.0}, {NAN}, Outside::refuse), Error);
}

}  // namespace
}  // namespace drover::numerics::spline_table_tests
