// tests/numerics/contour.cpp: traced lines against curves in closed form, and the documented limits of accuracy.
#include "numerics/algebra/contour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"
#include "numerics/curves.hpp"

namespace drover::numerics::contour_tests {
namespace {

using std::numbers::pi;

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
const Rectangle oblong{.x0 = -1.3, .x1 = 1.1, .y0 = -1.6, .y1 = 1.2};  // nothing of a curve about 0 lies on its lattice
constexpr double oblong_side = 2.8;

Contour trace(const PlaneFunction& f, const Rectangle& where = oblong, const ContourOptions& options = {}) {
    Threads threads(2);
    return trace_zero(f, where, options, on_threads(threads));
}

Curve straight_curve(const Frame& frame, double height) {
    return curve([=](double t) { return frame.outward({t, height}); }, -2.5, 2.5);
}

double area_of(const ContourLine& line) {
    double twice = 0.0;
    for (std::size_t n = 0; n < line.points.size(); ++n) {
        const PlanePoint &a = line.points[n], &b = line.points[(n + 1) % line.points.size()];
        twice +=
            (a.x - line.points[0].x) * (b.y - line.points[0].y) - (b.x - line.points[0].x) * (a.y - line.points[0].y);
    }
    return 0.5 * twice;
}

bool is_within(const Rectangle& where, const PlanePoint& p) {
    return p.x >= where.x0 && p.x <= where.x1 && p.y >= where.y0 && p.y <= where.y1;
}

/// The documented accuracy of smooth lines, in a rectangle whose longer side is oblong_side.
void expect_smooth(const Contour& contour, const std::vector<Curve>& curves) {
    const Misses worst = misses(contour, curves, [](const PlanePoint& p) { return is_within(oblong, p); });
    EXPECT_LT(worst.vertices, 1e-8);  // required; the errors of the root, 1e-12, and of the golden section are smaller
    EXPECT_LT(worst.pieces, 1e-4 * oblong_side);    // the chord
    EXPECT_LT(worst.covering, 2e-4 * oblong_side);  // twice the chord
    EXPECT_LT(worst.turn, 0.46);                    // 26 degrees
    EXPECT_TRUE(contour.complete);
    EXPECT_TRUE(contour.singular_points.empty());
}

/// The documented accuracy at one cusp, double point or corner at `place`: 1e-5 within 1e-3 of it, elsewhere as if
/// smooth.
void expect_smooth_but_at(const PlanePoint& place, const Contour& contour, const std::vector<Curve>& curves) {
    const auto is_near = [&](const PlanePoint& p) { return distance(p, place) < 1e-3; };
    const Misses close = misses(contour, curves, is_near);
    const Misses far =
        misses(contour, curves, [&](const PlanePoint& p) { return !is_near(p) && is_within(oblong, p); });
    EXPECT_LT(std::max({close.vertices, close.pieces, close.covering}), 1e-5);
    EXPECT_LT(far.vertices, 1e-8);
    EXPECT_LT(far.pieces, 1e-4 * oblong_side);
    EXPECT_LT(far.covering, 2e-4 * oblong_side);
    EXPECT_LT(far.turn, 0.46);
    EXPECT_LT(distance_to_lines(place, contour), 1e-5);
    EXPECT_TRUE(contour.complete);
    ASSERT_EQ(contour.singular_points.size(), 1u);
    EXPECT_LT(distance(contour.singular_points[0], place), 1e-5);
}

// Of the unit square, 1/4 by 1/2 is negative, 3/4 by 1/2 positive and the rest undefined; cells along the lines between
// them are 1/64 wide.
TEST(Contour, GivesTheFractionsOfEitherSign) {
    const Contour found = trace([](const PlanePoint& p) { return p.y > 0.5 ? undefined : p.x - 0.25; }, {});
    EXPECT_NEAR(found.negative, 0.125, 1.0 / 64.0);
    EXPECT_NEAR(found.positive, 0.375, 1.0 / 64.0);
}

TEST(Contour, an_ellipse_is_one_closed_line_with_the_positive_side_to_its_left) {
    const Frame frame{.x = 0.07, .y = -0.13, .angle = 0.7};
    for (const double sign : {1.0, -1.0}) {
        const Contour contour = trace([&](const PlanePoint& p) {
            const PlanePoint q = frame.inward(p);
            return sign * (1.0 - q.x * q.x / 0.81 - q.y * q.y / 0.16);
        });
        ASSERT_EQ(contour.lines.size(), 1u);
        EXPECT_TRUE(contour.lines[0].closed);
        const auto at = [&](double t) { return frame.outward({0.9 * std::cos(t), 0.4 * std::sin(t)}); };
        expect_smooth(contour, {curve(at, 0.0, 2.0 * pi)});
        EXPECT_NEAR(sign * area_of(contour.lines[0]), pi * 0.36, 1e-3);  // chord times length
    }
}

TEST(Contour, a_circle_takes_few_more_evaluations_than_the_lattice) {
    const auto circle = [](const PlanePoint& p) { return 0.0625 - std::pow(p.x - 0.51, 2) - std::pow(p.y - 0.47, 2); };
    const Contour contour = trace(circle, {});
    ASSERT_EQ(contour.lines.size(), 1u);
    const double lattice = 65.0 * 65.0 + 64.0 * 64.0;
    EXPECT_LT(static_cast<double>(contour.evaluations), lattice + 6000.0);  // some 400 crossings, a dozen calls each
}

TEST(Contour, a_crossing_is_searched_once_however_often_its_edge_is_halved) {
    const auto step = [](const PlanePoint& p) { return std::hypot(p.x - 0.51, p.y - 0.47) < 0.25 ? 1.0 : -1.0; };
    const Contour contour = trace(step, {}, {.cells = 16, .chord = 1e-6});
    EXPECT_LT(contour.evaluations, 120000u);  // 167000 when every half is searched anew
}

TEST(Contour, cassinian_ovals_are_one_line_or_two) {
    const Frame frame{.x = -0.04, .y = -0.19, .angle = 0.4};
    const double a = 0.6;
    for (const double b : {0.61, 0.59}) {
        const Contour contour = trace([&](const PlanePoint& p) {
            const PlanePoint q = frame.inward(p);
            return (std::pow(q.x - a, 2) + q.y * q.y) * (std::pow(q.x + a, 2) + q.y * q.y) - std::pow(b, 4);
        });
        ASSERT_EQ(contour.lines.size(), b > a ? 1u : 2u);
        const auto oval = [&](double sign) {  // of two: the angle swings, out with one root and back with the other
            return [&, sign](double t) {
                const double angle = b > a ? t : 0.5 * std::asin(b * b / (a * a)) * std::sin(t);
                const double inside = std::pow(b, 4) - std::pow(a * a * std::sin(2.0 * angle), 2);
                const double root = std::sqrt(std::max(0.0, inside)) * (b > a || std::cos(t) > 0.0 ? 1.0 : -1.0);
                const double r = sign * std::sqrt(std::max(0.0, a * a * std::cos(2.0 * angle) + root));
                return frame.outward({r * std::cos(angle), r * std::sin(angle)});
            };
        };
        std::vector<Curve> ovals{curve(oval(1.0), 0.0, 2.0 * pi)};
        if (b < a) ovals.push_back(curve(oval(-1.0), 0.0, 2.0 * pi));
        expect_smooth(contour, ovals);
    }
}

TEST(Contour, a_coarse_smooth_line_has_small_turns_between_segments) {
    const auto f = [](const PlanePoint& p) { return std::sin(9.0 * p.x) * p.y - std::cos(7.0 * p.y) * p.x - 0.1; };
    for (const int cells : {10, 13, 17, 21, 30}) {
        const Contour contour = trace(f, oblong, {.cells = cells, .chord = 0.1});
        EXPECT_GT(contour.lines.size(), 2u);
        EXPECT_TRUE(contour.singular_points.empty());
        EXPECT_LT(misses(contour, {}, [](const PlanePoint&) { return true; }).turn, 0.52);  // 26 degrees in a square
    }
}

TEST(Contour, a_cusp_is_followed_to_its_tip) {
    for (const Frame& frame : {Frame{.x = 0.1234, .y = -0.0567, .angle = 0.61}, Frame{.x = 0.3, .y = 0.2, .angle = 4.0},
                               Frame{.x = -0.1, .y = -0.2, .angle = 0.0}}) {
        const Contour contour = trace([&](const PlanePoint& p) {
            const PlanePoint q = frame.inward(p);
            return q.y * q.y - q.x * q.x * q.x;
        });
        EXPECT_EQ(contour.lines.size(), 1u);
        const auto at = [&](double t) { return frame.outward({t * t, t * t * t}); };
        expect_smooth_but_at({frame.x, frame.y}, contour, {curve(at, -1.5, 1.5, 2001), curve(at, -0.04, 0.04, 2000)});
    }
}

TEST(Contour, a_lemniscate_is_traced_through_its_double_point) {
    const Frame frame{.x = 0.0321, .y = -0.0765, .angle = 1.1};
    const Contour contour = trace([&](const PlanePoint& p) {
        const PlanePoint q = frame.inward(p);
        const double square = q.x * q.x + q.y * q.y;
        return square * square - 0.64 * (q.x * q.x - q.y * q.y);
    });
    const auto at = [&](double t) {
        const double r = 0.8 * std::cos(t) / (1.0 + std::pow(std::sin(t), 2));
        return frame.outward({r, r * std::sin(t)});
    };
    expect_smooth_but_at({frame.x, frame.y}, contour, {curve(at, 0.0, pi), curve(at, pi, 2.0 * pi)});
}

TEST(Contour, two_lines_may_cross) {
    for (const double angle : {0.2, 0.9}) {
        const Frame frame{.x = 0.0123, .y = 0.0456, .angle = angle};
        const Contour contour = trace([&](const PlanePoint& p) {
            const PlanePoint q = frame.inward(p);
            return q.x * q.x - q.y * q.y;
        });
        EXPECT_EQ(contour.lines.size(), 2u);
        const Frame up{.x = frame.x, .y = frame.y, .angle = angle + 0.25 * pi};
        const Frame down{.x = frame.x, .y = frame.y, .angle = angle - 0.25 * pi};
        expect_smooth_but_at({frame.x, frame.y}, contour, {straight_curve(up, 0.0), straight_curve(down, 0.0)});
    }
}

TEST(Contour, the_corners_of_a_square_are_kept) {
    const Frame frame{.x = 0.01, .y = -0.02, .angle = 0.5};
    for (const double angle : {0.0, 0.5}) {
        const Frame turned{.x = frame.x, .y = frame.y, .angle = angle};
        const Contour contour = trace([&](const PlanePoint& p) {
            const PlanePoint q = turned.inward(p);
            return std::abs(q.x) + std::abs(q.y) - 0.7;
        });
        ASSERT_EQ(contour.lines.size(), 1u);
        EXPECT_EQ(contour.singular_points.size(), 4u);
        for (const PlanePoint& corner : {PlanePoint{0.7, 0.0}, {0.0, 0.7}, {-0.7, 0.0}, {0.0, -0.7}}) {
            const PlanePoint place = turned.outward(corner);
            EXPECT_LT(distance_to_lines(place, contour), 1e-5);  // required; the finest mesh is about 3e-8 wide here
            EXPECT_TRUE(std::any_of(contour.singular_points.begin(), contour.singular_points.end(),
                                    [&](const PlanePoint& p) { return distance(p, place) < 1e-5; }));
        }
        EXPECT_LT(contour.evaluations, 20000u);  // four corners of some forty generations
    }
}

/// Numbers in [0, 1).
std::vector<double> uniform_numbers(std::size_t size, std::uint64_t seed) {
    std::vector<double> numbers(size);
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, numbers);
    for (double& number : numbers) number = 0.5 * std::erfc(-number / std::numbers::sqrt2);
    return numbers;
}

TEST(ContourLong, every_island_just_wider_than_a_cell_is_found_and_not_every_one_of_half_the_width) {
    const int cells = 10;
    const double wide = 0.5 * 1.0001 / cells;  // the radius
    const std::vector<double> random = uniform_numbers(800, 5);
    std::vector<PlanePoint> centres;
    for (std::size_t n = 0; n < random.size(); n += 2)
        centres.push_back({std::lerp(wide, 1.0 - wide, random[n]), std::lerp(wide, 1.0 - wide, random[n + 1])});
    for (int i = 1; i + 1 < cells; ++i)  // the middles of the sides of the cells are farthest from all samples
        for (int j = 1; j < cells; ++j) centres.push_back({(i + 0.5) / cells, static_cast<double>(j) / cells});
    std::size_t missed = 0;
    for (const PlanePoint& centre : centres)
        for (const double sign : {1.0, -1.0}) {
            const auto disc = [&](double radius) {
                return trace([&](const PlanePoint& p) { return sign * (distance(p, centre) - radius); }, {},
                             {.cells = cells, .chord = 1e-3});
            };
            const Contour found = disc(wide);
            ASSERT_EQ(found.lines.size(), 1u) << centre.x << " " << centre.y;
            EXPECT_NEAR(sign * area_of(found.lines[0]), -pi * wide * wide, 3.2e-4);  // chord times length
            missed += disc(0.5 * wide).lines.empty() ? 1 : 0;
        }
    EXPECT_GT(missed, 0u);
}

TEST(ContourLong, a_strip_thinner_than_a_cell_is_followed_from_any_sample_in_it) {
    // A strip of width 1e-3 at a slope: the lattice of spacing 1/8 has few points in it.
    const Frame frame{.x = 0.5, .y = 0.5, .angle = 0.37};
    const Contour contour =
        trace([&](const PlanePoint& p) { return std::abs(frame.inward(p).y) - 5e-4; }, {}, {.cells = 8});
    EXPECT_EQ(contour.lines.size(), 2u);
    const Misses worst = misses(contour, {straight_curve(frame, 5e-4), straight_curve(frame, -5e-4)},
                                [](const PlanePoint& p) { return is_within({}, p); });
    EXPECT_LT(worst.vertices, 1e-8);  // wanted
    EXPECT_LT(worst.covering, 1e-8);  // straight lines
    EXPECT_TRUE(contour.singular_points.empty());
}

TEST(Contour, a_tongue_is_followed_to_its_end) {
    // A needle 0.1 wide at x = -0.7 and 1e-4 wide at x = 0.7, where it ends squarely.
    const Frame frame{.x = 0.02, .y = -0.03, .angle = 0.3};
    const auto half = [](double x) { return 5e-5 + 0.0357 * (0.7 - x); };
    const Contour contour = trace([&](const PlanePoint& p) {
        const PlanePoint q = frame.inward(p);
        return std::min({half(q.x) - std::abs(q.y), 0.7 - q.x, q.x + 0.7});
    });
    ASSERT_EQ(contour.lines.size(), 1u);
    for (const double x : {-0.7, 0.7})
        for (const double sign : {1.0, -1.0})
            EXPECT_LT(distance_to_lines(frame.outward({x, sign * half(x)}), contour), 1e-5);  // corners, as elsewhere
}

TEST(Contour, an_islet_beside_a_line_is_found_by_the_middle_of_an_edge) {
    const auto f = [](const PlanePoint& p) {
        return std::min(p.y - 0.51, std::max(std::abs(p.x - 0.53125) - 1e-3, std::abs(p.y - 0.59375) - 1e-2));
    };
    const Contour contour = trace(f, {}, {.cells = 8});
    ASSERT_EQ(contour.lines.size(), 2u);
    EXPECT_EQ(contour.singular_points.size(), 4u);
    EXPECT_NEAR(area_of(contour.lines[1]), -4e-5, 1e-9);  // straight sides, and corners found to 1e-5 and better
}

TEST(Contour, a_jump_is_traced_by_its_signs) {
    const Frame frame{.x = 0.05, .y = 0.02, .angle = 0.8};
    const auto height = [&](const PlanePoint& p) { return frame.inward(p).y; };
    const double infinity = std::numeric_limits<double>::infinity();
    std::vector<PlaneFunction> jumps;
    for (const auto& [above, below] : std::vector<std::pair<double, double>>{
             {1.0, -1.0}, {infinity, -infinity}, {1e-300, -infinity}, {0.0, -1.0}, {-1e-9, 1.0}})
        jumps.emplace_back([&, above = above, below = below](const PlanePoint& p) {
            return (height(p) > 0.0 ? above : below) * (1.0 + p.x * p.x);
        });
    jumps.emplace_back([&](const PlanePoint& p) { return 1.0 / height(p); });
    for (const PlaneFunction& jump : jumps) {
        const Contour contour = trace(jump);
        ASSERT_EQ(contour.lines.size(), 1u);
        EXPECT_FALSE(contour.lines[0].closed);
        expect_smooth(contour, {straight_curve(frame, 0.0)});
    }
}

TEST(Contour, a_line_ends_at_the_edge_of_the_domain_of_the_function) {
    const Frame frame{.x = 0.513, .y = 0.479, .angle = 0.9};
    for (const double slope : {0.0, 1.0, 10.0}) {  // of the line, against the normal of the edge
        const Contour contour = trace(
            [&](const PlanePoint& p) {
                const PlanePoint q = frame.inward(p);
                return q.x > 0.0 ? undefined : q.y + slope * q.x + 0.3 * q.x * q.x;
            },
            {});
        ASSERT_EQ(contour.lines.size(), 1u);
        double nearest = 1.0;
        for (const PlanePoint& p : contour.lines[0].points) {
            const PlanePoint q = frame.inward(p);
            EXPECT_LE(q.x, 0.0);
            EXPECT_LT(std::abs(q.y + slope * q.x + 0.3 * q.x * q.x), 1e-8);  // wanted
            nearest = std::min(nearest, -q.x);
        }
        EXPECT_LT(nearest, 1e-3);  // documented: 1/1024
        EXPECT_LT(contour.evaluations, 20000u);
    }
}

TEST(Contour, a_sign_change_across_a_strip_where_the_function_is_undefined_is_not_a_line) {
    for (const double half : {2e-3, 1e-4})  // of its width: above and below what the mesh is refined to
        EXPECT_TRUE(trace(
                        [=](const PlanePoint& p) {
                            const double height = p.y - 0.4 - 0.3 * p.x;
                            return std::abs(height) < half ? undefined : height;
                        },
                        {})
                        .lines.empty());
}

TEST(Contour, a_line_that_leaves_ends_on_the_border) {
    const Rectangle where{.x0 = -0.1, .x1 = 0.7, .y0 = 1.0 / 3.0, .y1 = 1.3};  // sides that do not round to themselves
    const auto on_border = [&](const PlanePoint& p) {
        return p.x == where.x0 || p.x == where.x1 || p.y == where.y0 || p.y == where.y1;
    };
    for (const double angle : {0.0, 0.3, 1.2, 2.0, 3.7, 5.5}) {
        const Frame frame{.x = 0.21, .y = 0.77, .angle = angle};
        const Contour contour = trace([&](const PlanePoint& p) { return frame.inward(p).y; }, where);
        ASSERT_EQ(contour.lines.size(), 1u);
        EXPECT_FALSE(contour.lines[0].closed);
        EXPECT_TRUE(on_border(contour.lines[0].points.front()));
        EXPECT_TRUE(on_border(contour.lines[0].points.back()));
        EXPECT_LT(frame.inward(contour.lines[0].points.front()).x, frame.inward(contour.lines[0].points.back()).x);
    }
}

TEST(Contour, a_line_that_leaves_beside_a_vertex_ends_on_the_border) {
    for (const double sign : {1.0, -1.0}) {
        const Contour contour =
            trace([=](const PlanePoint& p) { return sign * (p.y - 0.5 - 3e-12 - 0.3 * p.x); }, {}, {.cells = 8});
        ASSERT_EQ(contour.lines.size(), 1u);
        const auto& points = contour.lines[0].points;
        EXPECT_EQ(sign > 0.0 ? points.front().x : points.back().x, 0.0);
    }
}

TEST(Contour, the_function_is_not_called_outside_the_rectangle) {
    for (const double x : {oblong.x0 + 1e-9, oblong.x1 - 1e-9, 0.0})
        trace([&](const PlanePoint& p) {
            EXPECT_TRUE(is_within(oblong, p));
            return p.x - x;
        });
}

TEST(Contour, a_line_through_lattice_points_is_complete_and_its_points_are_distinct) {
    const Contour contour = trace([](const PlanePoint& p) { return p.x - p.y; }, {}, {.cells = 8});
    ASSERT_EQ(contour.lines.size(), 1u);
    const auto& points = contour.lines[0].points;
    EXPECT_NEAR(distance(points.front(), points.back()), std::numbers::sqrt2, 1e-14);
    for (std::size_t n = 1; n < points.size(); ++n) EXPECT_GT(distance(points[n - 1], points[n]), 1e-3);
}

TEST(Contour, a_function_without_sign_change_has_no_line) {
    for (const double value : {0.0, -0.0, 3.0, -2.0, undefined}) {
        const Contour contour = trace([=](const PlanePoint&) { return value; }, {}, {.cells = 5});
        EXPECT_TRUE(contour.lines.empty());
        EXPECT_TRUE(contour.singular_points.empty());
        EXPECT_TRUE(contour.complete);
        EXPECT_EQ(contour.evaluations, 61u);  // 36 corners, 25 centres
    }
    EXPECT_TRUE(trace([](const PlanePoint& p) { return p.x > 0.5 ? undefined : 1.0; }, {}).lines.empty());
}

TEST(Contour, a_function_that_is_only_noise_stops_at_the_evaluation_limit) {
    const auto noise = [](const PlanePoint& p) { return std::sin(1e9 * p.x) * std::sin(1.7e9 * p.y + 1.0); };
    const Contour contour = trace(noise, {}, {.cells = 16, .evaluations = 30000});
    EXPECT_FALSE(contour.complete);
    EXPECT_LT(contour.evaluations, 200000u);  // the last generation is finished: a few times more
    EXPECT_FALSE(contour.lines.empty());
}

TEST(Contour, the_lines_do_not_depend_on_the_number_of_threads) {
    const auto f = [](const PlanePoint& p) { return std::sin(9.0 * p.x) * p.y - std::cos(7.0 * p.y) * p.x; };
    Threads one(1), two(2), five(5);
    const Contour alone = trace_zero(f, oblong, {}, on_threads(one));
    ASSERT_GT(alone.lines.size(), 2u);
    for (Threads* threads : {&two, &five}) {
        const Contour together = trace_zero(f, oblong, {}, on_threads(*threads));
        EXPECT_EQ(together.evaluations, alone.evaluations);
        ASSERT_EQ(together.lines.size(), alone.lines.size());
        for (std::size_t n = 0; n < alone.lines.size(); ++n) {
            ASSERT_EQ(together.lines[n].points.size(), alone.lines[n].points.size());
            EXPECT_EQ(together.lines[n].closed, alone.lines[n].closed);
            for (std::size_t k = 0; k < alone.lines[n].points.size(); ++k) {
                EXPECT_EQ(together.lines[n].points[k].x, alone.lines[n].points[k].x);
                EXPECT_EQ(together.lines[n].points[k].y, alone.lines[n].points[k].y);
            }
        }
    }
}

std::string why_no_error(const Rectangle& where, const ContourOptions& options) {
    try {
        trace([](const PlanePoint& p) { return p.x; }, where, options);
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
    return "";
}

TEST(Contour, options_out_of_range_are_rejected) {
    EXPECT_EQ(why_no_error({.x0 = 1.0, .x1 = 1.0}, {}),
              "a rectangle from 1 to 1 by 0 to 1; expected finite sides above 0");
    EXPECT_EQ(why_no_error({.y1 = undefined}, {}),
              "a rectangle from 0 to 1 by 0 to nan; expected finite sides above 0");
    EXPECT_EQ(why_no_error({}, {.cells = 0}), "cells = 0; expected 1 to 2048");
    EXPECT_EQ(why_no_error({}, {.cells = 4096}), "cells = 4096; expected 1 to 2048");
    EXPECT_EQ(why_no_error({}, {.chord = 0.0}), "chord = 0; expected above 0 and below 1");
}

}  // namespace
}  // namespace drover::numerics::contour_tests
