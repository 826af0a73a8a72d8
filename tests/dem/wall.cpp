// tests/dem/wall.cpp: distances to side walls against finely sampled outlines.
#include "dem/bodies/walls.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem::wall_tests {
namespace {

using std::numbers::pi;

struct Point {
    double x = 0.0, y = 0.0;
};

/// The outline of a flower, anticlockwise, built from its corners alone: each arc by its centre on the bisector of a
/// chord.
std::vector<Point> outline(const Cell& cell, int each) {
    std::vector<Point> points;
    for (int k = 0; k < cell.petals; ++k) {
        const double a = (2 * k - 1) * pi / cell.petals, b = (2 * k + 1) * pi / cell.petals, middle = 0.5 * (a + b);
        const Point from{cell.radius * std::cos(a), cell.radius * std::sin(a)},
            to{cell.radius * std::cos(b), cell.radius * std::sin(b)};
        const double half = 0.5 * std::hypot(to.x - from.x, to.y - from.y);
        const double back = std::sqrt(std::max(0.0, cell.petal_radius * cell.petal_radius - half * half));
        const Point centre{0.5 * (from.x + to.x) - back * std::cos(middle),
                           0.5 * (from.y + to.y) - back * std::sin(middle)};
        const double wide = std::asin(std::min(1.0, half / cell.petal_radius));
        for (int i = 0; i < each; ++i) {
            const double angle = middle + wide * (2.0 * i / each - 1.0);
            points.push_back(
                {centre.x + cell.petal_radius * std::cos(angle), centre.y + cell.petal_radius * std::sin(angle)});
        }
    }
    return points;
}

bool is_within(const std::vector<Point>& polygon, const Point& p) {
    bool within = false;
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
        const Point &a = polygon[i], &b = polygon[j];
        if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) within = !within;
    }
    return within;
}

double distance(const std::vector<Point>& points, const Point& p) {
    double least = 1e300;
    for (const Point& q : points) least = std::min(least, std::hypot(p.x - q.x, p.y - q.y));
    return least;
}

/// The distances at which the outline is nearer than beside, seen from within, nearest first.
std::vector<double> nearest_places(const std::vector<Point>& points, const Point& p, double reach) {
    std::vector<double> result;
    const std::size_t n = points.size();
    const auto at = [&](std::size_t i) { return std::hypot(p.x - points[i % n].x, p.y - points[i % n].y); };
    for (std::size_t i = 0; i < n; ++i)
        if (const double here = at(i); here <= reach && here < at(i + n - 1) && here <= at(i + 1)) {
            const double back = std::min(0.01 / here, 1.0);
            const Point& q = points[i];
            // From a petal an arc of another can be near with its back.
            if (is_within(points, {q.x + back * (p.x - q.x), q.y + back * (p.y - q.y)})) result.push_back(here);
        }
    std::sort(result.begin(), result.end());
    return result;
}

Cell flower(int petals, double petal_radius) {
    return {.shape = CellShape::flower, .radius = 25.0, .petals = petals, .petal_radius = petal_radius};
}
const std::vector<Cell> flowers{flower(8, 12.0), flower(8, 25.0 * std::sin(pi / 8)),  // half circles
                                flower(8, 40.0),                                      // flatter than a circle
                                flower(3, 22.0), flower(5, 18.0),
                                flower(40, 2.5)};

std::vector<Point> random_places(const Cell& cell, std::size_t count) {
    std::vector<double> numbers(2 * count);
    fill_uniform({.seed = 5, .stream = Stream::test}, 0, 1, numbers);
    std::vector<Point> places;
    for (std::size_t i = 0; i < count; ++i)
        places.push_back(
            {half_width(cell) * (2.0 * numbers[2 * i] - 1.0), half_height(cell) * (2.0 * numbers[2 * i + 1] - 1.0)});
    return places;
}

TEST(Wall, of_a_flower_has_the_distance_of_its_outline_inside_and_outside) {
    // Points 0.002 mm apart at most: the nearest of them is off by (0.001)^2/(2 distance) from the arc, 0.001 at a
    // corner.
    for (const Cell& cell : flowers) {
        const int each = 80000 / cell.petals;
        const std::vector<Point> points = outline(cell, each);
        for (const Point& p : random_places(cell, 150)) {
            const double far = distance(points, p), sign = is_within(points, p) ? 1.0 : -1.0;
            for (const double reach : {60.0, 0.55}) {
                WallPoint found[4];
                const int count = Walls(cell).near(p.x, p.y, reach, found);
                if (sign * far > reach + 0.002) {
                    EXPECT_EQ(count, 0);
                    continue;
                }
                if (sign * far > reach - 0.002) continue;
                ASSERT_GE(count, 1) << cell.petals << " petals at " << p.x << ", " << p.y << " distance " << sign * far;
                EXPECT_NEAR(found[0].distance, sign * far, 0.002) << cell.petals << " " << p.x << " " << p.y;
                EXPECT_NEAR(std::hypot(found[0].nx, found[0].ny), 1.0, 1e-14);
                const Point foot{p.x - found[0].distance * found[0].nx, p.y - found[0].distance * found[0].ny};
                EXPECT_LT(distance(points, foot), 0.002) << "the normal points from the wall to the place";
            }
        }
    }
}

TEST(Wall, of_a_flower_is_found_at_each_local_minimum_of_the_distance) {
    for (const Cell& cell : flowers) {
        const std::vector<Point> points = outline(cell, 40000 / cell.petals);
        for (const Point& p : random_places(cell, 150))
            for (const double part : {0.1, 0.5, 1.0}) {
                const double reach = 25.0 * part;
                if (!is_within(points, p) || distance(points, p) < 0.01) continue;
                const std::vector<double> expected = nearest_places(points, p, reach);
                // On the edge of what is in reach either answer will do.
                if (std::any_of(expected.begin(), expected.end(), [&](double d) { return d > reach - 0.01; })) continue;
                WallPoint found[4];
                const int count = Walls(cell).near(p.x, p.y, reach, found);
                ASSERT_EQ(count, static_cast<int>(std::min<std::size_t>(4, expected.size())))
                    << cell.petals << " petals of " << cell.petal_radius << " at " << p.x << ", " << p.y << " reach "
                    << reach;
                for (int i = 0; i < count; ++i)
                    EXPECT_NEAR(found[i].distance, expected[static_cast<std::size_t>(i)], 0.005);
            }
    }
}

TEST(Wall, of_a_flower_whose_arcs_form_a_circle_equals_that_of_the_circle) {
    const Cell round{.shape = CellShape::circle, .radius = 25.0}, made = flower(8, 25.0);
    EXPECT_NEAR(area(made), area(round), 1e-10);
    std::vector<Point> places = random_places(round, 1000);
    for (int k = 0; k < 8; ++k)  // where two arcs meet there is one wall still
        places.push_back({24.9 * std::cos((k + 0.5) * pi / 4), 24.9 * std::sin((k + 0.5) * pi / 4)});
    for (const Point& p : places) {
        WallPoint expected[4], found[4];
        const int count = Walls(round).near(p.x, p.y, 3.0, expected);
        ASSERT_EQ(Walls(made).near(p.x, p.y, 3.0, found), count) << p.x << " " << p.y;
        if (count == 0) continue;
        EXPECT_NEAR(found[0].distance, expected[0].distance, 1e-12);
        EXPECT_NEAR(found[0].nx, expected[0].nx, 1e-10);
        EXPECT_NEAR(found[0].ny, expected[0].ny, 1e-10);
    }
}

TEST(Wall, of_a_petal_is_not_found_from_the_next_petal) {
    // Just beyond an inner corner, in the first petal: the arc of the second goes on as if through it.
    const Cell cell = flower(8, 12.0);
    const double corner = pi / 8;
    WallPoint found[4];
    const int count = Walls(cell).near(25.3 * std::cos(corner - 0.03), 25.3 * std::sin(corner - 0.03), 0.5, found);
    ASSERT_GE(count, 1);
    for (int i = 0; i < count; ++i) EXPECT_GT(found[i].distance, 0.0);
}

TEST(Wall, of_a_rectangle_is_found_twice_in_a_corner_nearest_first) {
    const Cell cell{.shape = CellShape::rectangle, .lx = 20.0, .ly = 10.0};
    WallPoint found[4];
    ASSERT_EQ(Walls(cell).near(9.7, -4.8, 0.5, found), 2);
    EXPECT_NEAR(found[0].distance, 0.2, 1e-14);
    EXPECT_EQ(found[0].ny, 1.0);
    EXPECT_NEAR(found[1].distance, 0.3, 1e-14);
    EXPECT_EQ(found[1].nx, -1.0);
    EXPECT_EQ(Walls(cell).near(0.0, 0.0, 4.9, found), 0);
    EXPECT_EQ(Walls(cell).near(0.0, 0.0, 11.0, found), 4);
    ASSERT_EQ(Walls(cell).near(10.5, 0.0, 0.1, found), 1);
    EXPECT_EQ(found[0].distance, -0.5);
}

TEST(Wall, a_periodic_cell_has_no_walls) {
    WallPoint found[4];
    EXPECT_EQ(Walls(Cell{}).near(22.4, 22.4, 5.0, found), 0);
}

TEST(Cell, has_the_area_and_the_extent_of_its_outline) {
    for (const Cell& cell : flowers) {
        // A polygon of n points on an arc of angle t misses (t/n)^2/6 of its segment: 1e-9 here.
        const std::vector<Point> points = outline(cell, 160000 / cell.petals);
        double sum = 0.0, width = 0.0, height = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Point &a = points[i], &b = points[(i + 1) % points.size()];
            sum += 0.5 * (a.x * b.y - a.y * b.x);
            width = std::max(width, std::abs(a.x));
            height = std::max(height, std::abs(a.y));
        }
        EXPECT_NEAR(area(cell) / sum, 1.0, 1e-8);
        EXPECT_NEAR(half_width(cell), width, 1e-6);
        EXPECT_NEAR(half_height(cell), height, 1e-6);
    }
    EXPECT_EQ(area({.lx = 30.0, .ly = 20.0}), 600.0);
    EXPECT_EQ(half_width({.shape = CellShape::circle, .radius = 7.0}), 7.0);
    EXPECT_EQ(half_height({.shape = CellShape::rectangle, .lx = 30.0, .ly = 20.0}), 10.0);
}

}  // namespace
}  // namespace drover::dem::wall_tests
