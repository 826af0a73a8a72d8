// tests/jobs/sweep_refinement.cpp: points about a line where something jumps, in any order of results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "jobs/sweep/sweep_plan.hpp"

namespace drover::jobs::sweep_refinement_tests {
namespace {
using Points = std::vector<std::vector<double>>;

bool is_in_circle(const std::vector<double>& at) { return std::hypot(at[0] - 0.05, at[1]) < 0.7; }
bool crosses_circle(const std::vector<double>& a, const std::vector<double>& b) {
    return is_in_circle(a) != is_in_circle(b);
}

Axes square_axes(int values) {
    std::vector<double> axis;
    for (int i = 0; i < values; ++i) axis.push_back(-1.0 + 2.0 * i / (values - 1.0));
    return {axis, axis};
}

TEST(SweepRefinement, without_a_change_the_grid_stays) {
    const Points points = refined_points(square_axes(5), 4, [](const auto&, const auto&) { return false; });
    EXPECT_EQ(points.size(), 25u);
    EXPECT_TRUE(std::is_sorted(points.begin(), points.end()));
}

TEST(SweepRefinement, a_change_everywhere_makes_the_whole_finer_grid) {
    const Points points = refined_points(square_axes(3), 2, [](const auto& a, const auto& b) { return a != b; });
    EXPECT_EQ(points, refined_points(square_axes(9), 1, [](const auto&, const auto&) { return false; }));
}

TEST(SweepRefinement, a_line_is_found_as_closely_as_the_finest_grid_allows) {
    constexpr int levels = 5;
    const double step = 0.5 / (1 << levels);  // of cells of side .5
    const Points points = refined_points(square_axes(5), levels, crosses_circle);
    const auto has = [&](double x, double y) {
        return std::any_of(points.begin(), points.end(),
                           [&](const auto& at) { return std::abs(at[0] - x) + std::abs(at[1] - y) < 1e-9; });
    };
    // The four corners of the finest cell about every place of the circle, except where it touches a border of cells.
    for (int degree = 0; degree < 360; ++degree) {
        const double angle = (degree + 0.37) * std::acos(-1.0) / 180.0;
        const double x = 0.05 + 0.7 * std::cos(angle), y = 0.7 * std::sin(angle);
        const double left = std::floor(x / step) * step, below = std::floor(y / step) * step;
        for (const double dx : {0.0, step})
            for (const double dy : {0.0, step}) EXPECT_TRUE(has(left + dx, below + dy)) << degree;
    }
    // The circle crosses 8 r/step cells; each has its corners, and the coarser ones twice as many in all.
    EXPECT_LT(static_cast<double>(points.size()), 4.0 * 8.0 * 0.7 / step);
    EXPECT_GT(static_cast<double>(points.size()), 8.0 * 0.7 / step);
}

TEST(SweepRefinement, the_order_of_results_does_not_matter) {
    const Axes axes = square_axes(4);
    const Points whole = refined_points(axes, 4, crosses_circle);
    std::mt19937 random(7);
    std::set<std::vector<double>> known;
    for (;;) {  // one more result at a time, of those that are wanted
        const Points wanted = refined_points(axes, 4, [&](const auto& a, const auto& b) {
            return known.contains(a) && known.contains(b) && crosses_circle(a, b);
        });
        Points left;
        std::set_difference(wanted.begin(), wanted.end(), known.begin(), known.end(), std::back_inserter(left));
        if (left.empty()) {
            EXPECT_EQ(wanted, whole);
            break;
        }
        std::shuffle(left.begin(), left.end(), random);
        known.insert(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(left.size(), 7)));
    }
}

TEST(SweepRefinement, three_keys_are_refined_as_two) {
    const Axes axes(3, {0.0, 1.0});
    const Points points =
        refined_points(axes, 2, [](const auto& a, const auto& b) { return (a[2] < 0.3) != (b[2] < 0.3); });  // a plane
    const auto count = [&](double z) {
        return std::count_if(points.begin(), points.end(), [&](const auto& at) { return at[2] == z; });
    };
    EXPECT_EQ(count(0.25), 25);
    EXPECT_EQ(count(0.75), 0);
}
}  // namespace
}  // namespace drover::jobs::sweep_refinement_tests
