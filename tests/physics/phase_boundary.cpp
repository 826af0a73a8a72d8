// tests/physics/phase_boundary.cpp: lines of lost stability against closed forms, with islands, cusps and error bands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/base/random.hpp"
#include "flock_model.hpp"
#include "physics/rod_bead_model.hpp"
#include "planes.hpp"

namespace drover::physics::phase_boundary_tests {
namespace {

using numerics::PlanePoint;
using std::numbers::pi;

PlaneAxis rods(double from, double to) {
    return {.name = "uniform.rod_density",
            .from = from,
            .to = to,
            .set = [](Model& m, double value) { m.uniform.rod_density = value; },
            .is_density = true};
}
PlaneAxis beads(double from, double to) {
    return {.name = "uniform.bead_density",
            .from = from,
            .to = to,
            .set = [](Model& m, double value) { m.uniform.bead_density = value; },
            .is_density = true};
}

/// a(rho, sigma) by monomials, over the densities 0 to 2.
Plane density_plane(double constant, std::vector<std::string> terms) {
    return {.model = {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
                      .drag = {.coefficient = 1.0},
                      .relaxation = {.rate = constant, .rate_terms = std::move(terms), .saturation = 1.0}},
            .x = beads(1e-3, 2.0),
            .y = rods(1e-3, 2.0)};
}

template <class Distance>
double farthest(const Boundary& boundary, Distance distance) {
    double most = 0.0;
    for (const BoundaryLine& line : boundary.lines)
        for (const BoundaryPoint& point : line.points) most = std::max(most, distance(point));
    return most;
}

TEST(PhaseBoundary, of_a_closed_island_is_on_its_circle) {
    // abar = (rho - 1)^2 + (sigma - 1.1)^2 - 0.09.
    const Plane plane = density_plane(1.0 + 1.21 - 0.09, {"-2 rho", "1 rho^2", "-2.2 sigma", "1 sigma^2"});
    Threads threads(2);
    const Boundary found = trace_boundary(plane, Limit::onset, {}, {}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1u);
    EXPECT_TRUE(found.lines[0].closed);
    EXPECT_LT(farthest(found, [](const BoundaryPoint& p) { return std::abs(std::hypot(p.x - 1.0, p.y - 1.1) - 0.3); }),
              1e-8);
    // Whole: the angles leave no gap wider than a cell.
    std::vector<double> angles;
    for (const BoundaryPoint& p : found.lines[0].points) angles.push_back(std::atan2(p.y - 1.1, p.x - 1.0));
    std::sort(angles.begin(), angles.end());
    for (std::size_t i = 1; i < angles.size(); ++i) EXPECT_LT(angles[i] - angles[i - 1], 0.15);
}

TEST(PhaseBoundary, with_a_cusp_is_followed_into_it) {
    // abar = (sigma - 1)^2 - (rho - 1)^3: a cusp at (1, 1).
    const Plane plane = density_plane(1.0 + 1.0, {"-2 sigma", "1 sigma^2", "-1 rho^3", "3 rho^2", "-3 rho"});
    Threads threads(2);
    const Boundary found = trace_boundary(plane, Limit::onset, {}, {}, on_threads(threads));
    // The nearest place of the curve (1 + t^2, 1 + t^3), by its stationary points in t from many starts.
    const auto distance = [](double x, double y) {
        double least = std::hypot(x - 1.0, y - 1.0);
        for (int n = -40; n <= 40; ++n) {
            double t = n / 40.0 + (y > 1.0 ? 1.0 : -1.0) * std::cbrt(std::abs(y - 1.0));
            for (int i = 0; i < 60; ++i) {
                const double dx = 1.0 + t * t - x, dy = 1.0 + t * t * t - y, slope = 2.0 * t * dx + 3.0 * t * t * dy;
                const double bend = 2.0 * dx + 4.0 * t * t + 6.0 * t * dy + 9.0 * t * t * t * t;
                if (bend == 0.0) break;
                t -= slope / bend;
            }
            least = std::min(least, std::hypot(1.0 + t * t - x, 1.0 + t * t * t - y));
        }
        return least;
    };
    double nearest = 1.0;
    for (const BoundaryLine& line : found.lines)
        for (const BoundaryPoint& p : line.points) {
            const double from_cusp = std::hypot(p.x - 1.0, p.y - 1.0);
            nearest = std::min(nearest, from_cusp);
            EXPECT_LT(distance(p.x, p.y), from_cusp < 1e-3 ? 1e-5 : 1e-8) << p.x << ", " << p.y;
        }
    // The terms of the margin add up to 12 there: rounding of 12 2^-52 hides a distance of its cube root, 1.4e-5.
    EXPECT_LT(nearest, std::cbrt(12.0 * 0x1p-52));
}

TEST(PhaseBoundary, with_a_double_point_is_followed_through_it) {
    // abar = (sigma - 1)^2 - (rho - 0.9)^2: two lines that cross.
    const Plane plane = density_plane(1.0 - 0.81, {"-2 sigma", "1 sigma^2", "-1 rho^2", "1.8 rho"});
    Threads threads(2);
    const Boundary found = trace_boundary(plane, Limit::onset, {}, {}, on_threads(threads));
    double nearest = 1.0;
    for (const BoundaryLine& line : found.lines)
        for (const BoundaryPoint& p : line.points) {
            const double away = std::hypot(p.x - 0.9, p.y - 1.0),
                         off = std::abs(std::abs(p.y - 1.0) - std::abs(p.x - 0.9)) / std::sqrt(2.0);
            nearest = std::min(nearest, away);
            EXPECT_LT(off, away < 1e-3 ? 1e-5 : 1e-8);
        }
    EXPECT_LT(nearest, 2e-4);  // a vertex that is not needed within the chord of 1e-4, of a plane 2 wide, is left out
}

PlaneAxis coefficient(const std::string& name, double from, double to, std::function<void(Model&, double)> set) {
    return {.name = name, .from = from, .to = to, .set = std::move(set)};
}

TEST(PhaseBoundary, of_rods_with_drag_lies_at_a_gain_of_two) {
    // One rod turns by lambda_s; with rotational diffusion Dr = a and g = lambda_s alpha/(Gamma Dr) order begins at g
    // = 2.
    Letters l{.gamma = 1.7, .alpha = 1.3};
    Plane plane{.model = flock_model(l),
                .x = coefficient("weathercock.strength", 0.2, 3.0,
                                 [](Model& m, double value) { m.weathercock.strength = value; }),
                .y = coefficient("relaxation.rate", 0.1, 1.0,
                                 [](Model& m, double value) { m.relaxation.rate = value; })};
    Threads threads(2);
    for (const std::string convention : {"single-rod", "mean"}) {
        plane.model.weathercock.convention = convention;
        const Boundary found = trace_boundary(plane, Limit::onset, {}, {}, on_threads(threads));
        ASSERT_EQ(found.lines.size(), 1u);
        for (const BoundaryPoint& p : found.lines[0].points)
            EXPECT_NEAR(p.x * l.alpha / (l.gamma * p.y), convention == "mean" ? 1.0 : 2.0,
                        1e-8 * 20.0);  // 1e-8 in place, y down to 0.1
    }
}

TEST(PhaseBoundaryLong, of_banding_is_the_closed_form) {
    // Rods: |abar| = slope^2/(4 b B + 2 w slope), abar = a - slope sigma; over the slope and sigma.
    constexpr double b = 0.7, pressure = 0.6, w = 0.5, a = 1.0;
    const Plane plane{.model = {.current = {.speed = 1.0},
                                .relaxation = {.rate = a, .saturation = b},
                                .elasticity = {.stiffness = 0.5},
                                .advection = {.strength = w},
                                .pressure = {.rods = pressure}},
                      .x = coefficient("relaxation.rate_terms", 0.2, 1.5,
                                       [](Model& m, double value) {
                                           m.relaxation.rate_terms = {text("{} sigma", -value)};
                                       }),
                      .y = rods(0.5, 4.0)};
    Threads threads(2);
    const Boundary found = trace_boundary(plane, Limit::banding, {}, {.cells = 32}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1u);
    for (const BoundaryPoint& p : found.lines[0].points) {
        EXPECT_NEAR(p.x * p.y - a, p.x * p.x / (4.0 * b * pressure + 2.0 * w * p.x), 1e-8);
        // Waves a little off p0 are like those along it: where these grow, so do those.
        EXPECT_LT(margins(plane, {{p.x, p.y - 1e-3}}, Limit::oblique)[0].value, 0.0);
    }
}

TEST(PhaseBoundary, of_oblique_waves_with_speeds_alone_is_where_two_meet) {
    // Rods only, constant coefficients: u (u - v1 c) = s^2 Bbar: real at every angle unless Bbar < 0, and then not
    // across.
    const Plane plane{.model = {.uniform = {.rod_density = 1.0},
                                .current = {.speed = 1.0},
                                .relaxation = {.rate = -0.4, .saturation = 1.0},
                                .elasticity = {.stiffness = 0.5}},
                      .x = coefficient("pressure.rods", -1.0, 1.3,
                                       [](Model& m, double value) { m.pressure.rods = value; }),
                      .y = coefficient("advection.strength", 0.1, 1.0,
                                       [](Model& m, double value) { m.advection.strength = value; })};
    Threads threads(2);
    const Boundary found = trace_boundary(plane, Limit::oblique, {}, {.cells = 16}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1u);
    // Angles are refined to 1e-6, speeds that differ by 3e-7 of the largest count as one.
    EXPECT_LT(farthest(found, [](const BoundaryPoint& p) { return std::abs(p.x); }), 1e-6);
}

TEST(PhaseBoundary, of_phase_separation_is_where_densities_attract) {
    // E Bbar = F Abar over A and F, above the threshold of order.
    const Letters l = isotropic_letters();
    const Plane plane{.model = flock_model(l),
                      .x = coefficient("pressure.beads", 0.0, 3.0,
                                       [](Model& m, double value) { m.pressure.beads = value; }),
                      .y = coefficient("stiffness.rods", 0.0, 4.0,
                                       [](Model& m, double value) { m.stiffness.rods = value; })};
    Threads threads(2);
    const Boundary found = trace_boundary(plane, Limit::phase_separation, {}, {.cells = 32}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1u);
    for (const BoundaryPoint& p : found.lines[0].points) {
        const double bbar = l.pressure_b + l.lambda * p.y / l.gamma, abar = p.x + l.lambda * l.e / l.gamma;
        EXPECT_NEAR(l.e * bbar, p.y * abar, 1e-7);
    }
}

TEST(PhaseBoundary, outside_a_table_is_not_traced) {
    Plane plane = density_plane(0.0, {});
    plane.model.table = {.bead_density = {0.5, 1.0, 1.5},
                         .rod_density = {0.5, 1.5},
                         .columns = {{"relaxation.rate", {{0.5, 0.4, 0.0, -0.1, -0.5, -0.6}, {}}}}};
    plane.model.uniform = {.rod_density = 1.0, .bead_density = 1.0};
    Threads threads(1);
    const Boundary found = trace_boundary(plane, Limit::onset, {}, {}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1u);
    EXPECT_FALSE(found.lines[0].closed);
    EXPECT_EQ(farthest(found,
                       [](const BoundaryPoint& p) {
                           return p.y < 0.5 || p.y > 1.5 || p.x < 0.5 || p.x > 1.5 ? 1.0 : 0.0;
                       }),
              0.0);
    double low = 2.0, high = 0.0;
    for (const BoundaryPoint& p : found.lines[0].points) low = std::min(low, p.y), high = std::max(high, p.y);
    EXPECT_NEAR(low, 0.5, 0.005);
    EXPECT_NEAR(high, 1.5, 0.005);
}

TEST(PhaseBoundary, outside_a_table_is_not_traced_against_another_parameter) {
    Plane plane = density_plane(0.0, {});
    plane.model.table = {.bead_density = {0.5, 1.5}, .columns = {{"relaxation.rate", {{1.0, -1.0}, {}}}}};
    plane.model.uniform = {.rod_density = 1.0, .bead_density = 1.0};
    plane.x = beads(0.6, 3.0);
    plane.y =
        coefficient("relaxation.saturation", 0.5, 2.0, [](Model& m, double value) { m.relaxation.saturation = value; });
    Threads threads(1);
    const Boundary found = trace_boundary(plane, Limit::onset, {}, {.cells = 16}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1u);
    EXPECT_LT(farthest(found, [](const BoundaryPoint& p) { return std::abs(p.x - 1.0); }), 1e-8);
}

TEST(PhaseBoundary, in_a_field_has_no_onset) {
    Plane plane = density_plane(1.0, {"-1 rho"});
    plane.model.orienting_field = {.x = 0.01};
    Threads threads(1);
    EXPECT_TRUE(trace_boundary(plane, Limit::onset, {}, {.cells = 8}, on_threads(threads)).lines.empty());
}

TEST(PhaseBoundary, of_an_invalid_model_names_the_point) {
    Plane plane{.model = flock_model({}),
                .x = coefficient("drag.coefficient", -1.0, 2.0,
                                 [](Model& m, double value) { m.drag.coefficient = value; }),
                .y = coefficient("relaxation.rate", 0.1, 1.0,
                                 [](Model& m, double value) { m.relaxation.rate = value; })};
    plane.model.fields.bead_velocity = "slaved";
    Threads threads(1);
    try {
        trace_boundary(plane, Limit::onset, {}, {}, on_threads(threads));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("at drag.coefficient = ", 0), 0u) << error.what();
        EXPECT_NE(std::string(error.what()).find("expected > 0"), std::string::npos) << error.what();
    }
}

// A table of measured a, alpha and lambda with errors: the true line is that of the true values; bands about lines
// traced from values drawn with those errors must hold it as often as a normal law says.
TEST(PhaseBoundaryStatistics, bands_cover_the_true_line_as_often_as_stated) {
    Plane truth = density_plane(0.0, {});
    DensityTable& t = truth.model.table;
    t.bead_density = {0.0, 0.7, 1.4, 2.1};
    t.rod_density = {0.0, 1.0, 2.1};
    for (const double rho : t.bead_density)
        for (const double sigma : t.rod_density) {
            t.columns["relaxation.rate"].values.push_back(1.2 - 0.2 * sigma);
            t.columns["driving.strength"].values.push_back(0.5 + 0.5 * rho);
            t.columns["weathercock.strength"].values.push_back(0.6 + 0.1 * rho * sigma);
            t.columns["relaxation.rate"].errors.push_back(0.02);
            t.columns["driving.strength"].errors.push_back(0.015);
            t.columns["weathercock.strength"].errors.push_back(0.01 + 0.005 * rho);
        }
    Threads threads(2);
    const numerics::ContourOptions coarse{.cells = 6, .chord = 1e-3};
    const std::vector<Uncertain> uncertain = table_errors(truth.model);
    ASSERT_EQ(uncertain.size(), 36u);
    constexpr int trials = 200;
    int within_band = 0;
    std::vector<double> numbers(uncertain.size());
    for (int trial = 0; trial < trials; ++trial) {
        fill_normal({.seed = 20141021, .stream = Stream::test, .step = static_cast<std::uint64_t>(trial)}, 0, 1,
                    numbers);
        Plane drawn = truth;
        for (std::size_t i = 0; i < uncertain.size(); ++i)
            uncertain[i].add(drawn.model, numbers[i] * uncertain[i].error);
        std::vector<Model> draws(60, drawn.model);
        draw_errors(uncertain, draws);
        const Boundary found = trace_boundary(drawn, Limit::onset, draws, coarse, on_threads(threads));
        ASSERT_EQ(found.lines.size(), 1u);
        // One point of each, so that trials are independent: half-way along.
        const BoundaryPoint& p = found.lines[0].points[found.lines[0].points.size() / 2];
        ASSERT_TRUE(std::isfinite(p.band.x_low) && std::isfinite(p.band.x_high));
        const auto true_margin = [&](double x) { return margins(truth, {{x, p.y}}, Limit::onset)[0].value; };
        within_band += true_margin(p.band.x_low) * true_margin(p.band.x_high) < 0.0;
    }
    // Binomial: 136.5 +- 6.6 of 200; four deviations.
    EXPECT_NEAR(within_band, 0.6827 * trials, 26.0);
}

}  // namespace
}  // namespace drover::physics::phase_boundary_tests
