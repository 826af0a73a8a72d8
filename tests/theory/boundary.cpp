// tests/theory/boundary.cpp: margins of stability and their lines against exact ones.
#include "theory/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/draws.hpp"
#include "drover/base/random.hpp"
#include "theory/models.hpp"

namespace drover::theory::boundary_tests {
namespace {
/// The model with two coefficients as the axes of a plane, and the margin of a state.
MarginOf plane_of(const model::Model& model, const std::string& x, const std::string& y, MarginState state,
                  const std::string& changed = {}, double by = 0.0) {
    const StationaryStates found = stationary_states(model::Equations(model));
    KnownStates known{.values = {}, .ordered = ordered_states(found)};
    for (const StationaryState& one : found.states) known.values.push_back(one.values);
    return [=](const numerics::PlanePoint& point) {
        model::Model at = model;
        at.coefficients[x] = point.x;
        at.coefficients[y] = point.y;
        if (!changed.empty()) at.coefficients[changed] += by;
        return margin(model::Equations(at), state, known, {.min = 1e-2, .max = 10.0, .wavenumbers = 31, .angles = 12});
    };
}

/// The largest distance of the vertices from y = line(x).
template <class Line>
double farthest(const Boundary& found, Line line) {
    double most = 0.0;
    for (const BoundaryLine& one : found.lines)
        for (const BoundaryPoint& point : one.points) most = std::max(most, std::abs(point.y - line(point.x)));
    return most;
}

model::Model brusselator() {
    model::Field u = scalar("u", "a - (b + 1) u + u^2 v + Du lap u"), v = scalar("v", "b u - u^2 v + Dv lap v");
    u.reference = 2.0;
    v.reference = 2.0;
    return {.fields = {u, v}, .definitions = {}, .coefficients = {{"a", 3.0}, {"b", 9.0}, {"Du", 5.0}, {"Dv", 12.0}}};
}

// Prigogine and Lefever (1968): the state (a, b/a) becomes unstable at b = (1 + a sqrt(Du/Dv))^2 to waves of
// q^2 = a/sqrt(Du Dv), or at b = 1 + a^2 to uniform oscillations of frequency a, whichever is first.
TEST(ModelBoundaryLong, OfTheBrusselatorHasATuringPartAndAHopfPart) {
    Threads threads(1);
    const Boundary found = trace_boundary({.x0 = 0.5, .x1 = 4.0, .y0 = 1.0, .y1 = 12.0},
                                          plane_of(brusselator(), "a", "b", MarginState::isotropic), {},
                                          {.cells = 8, .chord = 1e-2}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    const double ratio = std::sqrt(5.0 / 12.0);
    const auto turing = [&](double a) { return std::pow(1.0 + a * ratio, 2.0); };
    // A vertex is where the sign changes to 1e-12 of an edge; the rate at a maximum over q is exact to the square of
    // the error 1e-9 of its place.
    EXPECT_LT(farthest(found, [&](double a) { return std::min(turing(a), 1.0 + a * a); }), 1e-9);
    int waves = 0, oscillations = 0;
    for (const BoundaryPoint& point : found.lines[0].points) {
        const bool is_turing = turing(point.x) < 1.0 + point.x * point.x;
        if (std::abs(turing(point.x) - 1.0 - point.x * point.x) < 1e-3) continue;  // both at once
        EXPECT_EQ(point.at.is_uniform, !is_turing) << point.x;
        ++(is_turing ? waves : oscillations);
        if (is_turing) {
            EXPECT_NEAR(point.at.q * point.at.q, point.x / std::sqrt(60.0), 1e-6);
        } else {
            EXPECT_NEAR(point.at.frequency, point.x, 1e-6);
        }
    }
    EXPECT_GT(waves, 3);
    EXPECT_GT(oscillations, 3);
}

// u grows at f - c (1 - q^2)^2, largest at f, and lies below v at each of the 31 wavenumbers of a search of which none
// is 1: at the nearest one it is 0.005 c below its maximum.  v decays at 0.002 + 0.1 q^2 slope.
TEST(ModelBoundary, FindsAPatternThatASlowWaveHidesAtAllWavesOfTheSearch) {
    const GrowthSearch search{.min = 0.9e-2, .max = 10.0, .wavenumbers = 31};
    for (const double c : {1.0, 30.0, 1e3, 1e5})
        for (const double slope : {0.0, 0.01})
            for (const double f : {-1e-6, 1e-6}) {
                const model::Equations equations({.fields = {scalar("u", "f u - c (u + 2 lap u + lap lap u)"),
                                                             scalar("v", "-0.002 v + 0.1 slope lap v")},
                                                  .definitions = {},
                                                  .coefficients = {{"f", f}, {"c", c}, {"slope", slope}}});
                const Margin found = margin(equations, MarginState::isotropic, {}, search);
                SCOPED_TRACE(testing::Message() << "c " << c << ", slope " << slope << ", f " << f);
                // The weight of long waves, 1 + min max/q^2, varies by 1e-5 over the waves that matter here, |1 - q|
                // < 1e-3; a place found to 1e-8 leaves 4e-16 c.
                EXPECT_NEAR(found.value, -f * (1.0 + search.min * search.max), std::abs(f) * 1e-3 + 4e-15 * c);
                EXPECT_NEAR(found.q, 1.0, 1e-3);
                const std::vector<Band> bands = growth_bands(about(equations.model()), 0.0, search);
                ASSERT_EQ(bands.size(), f > 0.0 ? 1U : 0U);
                if (f > 0.0) {
                    EXPECT_NEAR(bands.front().growth.rate, f, f * 1e-3 + 4e-15 * c);
                }
            }
}

// The same about an order along x, whose turns decay at 0.001 q^2 at all angles; u grows at the angle 55 degrees alone,
// between two angles of the search.
TEST(ModelBoundary, FindsAPatternThatATurnHidesAtAllAnglesOfTheSearch) {
    const double along = std::pow(std::cos(55.0 * pi / 180.0), 2.0);
    const GrowthSearch search{.min = 0.9e-2, .max = 10.0, .wavenumbers = 31, .angles = 18};
    for (const double f : {-1e-6, 1e-6}) {
        const model::Equations equations(
            {.fields = {spin(1, "p", "(1 - p.p) p + 0.001 lap p"),
                        scalar("u",
                               "f u - c (u + 2 lap u + lap lap u) - c (p.grad(p.grad(p.grad(p.grad u)))"
                               " - 2 along p.grad(p.grad lap u) + along^2 lap lap u)")},
             .definitions = {},
             .coefficients = {{"f", f}, {"c", 100.0}, {"along", along}}});
        const Margin found = margin(equations, MarginState::ordered, {}, search);
        EXPECT_NEAR(found.value, -f * (1.0 + search.min * search.max), std::abs(f) * 1e-2) << f;
        EXPECT_NEAR(std::pow(std::cos(found.angle), 2.0), along, 1e-4) << f;
    }
}

// A conserved density: d_t phi = lap(r phi + phi^3 - lap phi) separates where r + 3 phi0^2 < 0, first in long waves.
TEST(ModelBoundary, OfPhaseSeparationIsThatOfTheLongestWaves) {
    Threads threads(1);
    const MarginOf margin = [](const numerics::PlanePoint& point) {
        model::Field phi = scalar("phi", "lap(r phi + phi^3 - lap phi)");
        phi.conserved = true;
        phi.reference = point.y;
        const model::Model model{.fields = {phi}, .definitions = {}, .coefficients = {{"r", point.x}}};
        return theory::margin(model::Equations(model), MarginState::isotropic, {},
                              {.min = 1e-2, .max = 10.0, .wavenumbers = 31});
    };
    const Boundary found = trace_boundary({.x0 = -1.0, .x1 = 1.0, .y0 = 0.05, .y1 = 1.0}, margin, {},
                                          {.cells = 8, .chord = 1e-2}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    EXPECT_LT(farthest(found, [](double r) { return std::sqrt(-r / 3.0); }), 1e-9);
    for (const BoundaryPoint& point : found.lines[0].points) {
        EXPECT_EQ(point.at.q, 0.0);
        EXPECT_FALSE(point.at.is_uniform);
    }
}

// The order p.p = m drives phi where k > m; without order, m < 0, there is no such line.  The turn of the order, which
// neither grows nor decays, is no instability.
TEST(ModelBoundaryLong, OfAnOrderedStateIsNoPlaceOfItsFreeDirection) {
    Threads threads(1);
    const model::Model model{.fields = {spin(1, "p", "(m - p.p - phi^2) p + lap p"),
                                        scalar("phi", "(k - p.p) phi - phi^3 + lap phi")},
                             .definitions = {},
                             .coefficients = {{"m", 1.0}, {"k", 0.5}}};
    const Boundary found =
        trace_boundary({.x0 = 0.2, .x1 = 1.0, .y0 = 0.1, .y1 = 1.5}, plane_of(model, "m", "k", MarginState::ordered),
                       {}, {.cells = 1, .chord = 0.2}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    EXPECT_LT(farthest(found, [](double m) { return m; }), 1e-9);
    EXPECT_TRUE(std::isnan(plane_of(model, "m", "k", MarginState::ordered)({-0.2, 0.5}).value));
}

// Turns of the order decay as q^2, the slowest of all; long waves are weighted by min max of the search.
TEST(ModelBoundary, OfAnOrderedStateThatKnownStatesDoNotLeadToIsThatOfTheWholeSearch) {
    const model::Equations equations(
        {.fields = {spin(1, "p", "(m - p.p) p + lap p")}, .definitions = {}, .coefficients = {{"m", 0.25}}});
    const GrowthSearch search{.min = 1e-2, .max = 10.0, .wavenumbers = 31, .angles = 12};
    const KnownStates found{.values = {{1.0, 0.0}}, .ordered = 1},
        isotropic_alone{.values = {{0.0, 0.0}}, .ordered = 1}, none{.values = {{1.0, 0.0}}, .ordered = 0};
    const Margin whole = margin(equations, MarginState::ordered, {}, search);
    EXPECT_NEAR(whole.value, search.min * search.max, 1e-12);
    for (const KnownStates& known : {found, isotropic_alone, none})
        EXPECT_NEAR(margin(equations, MarginState::ordered, known, search).value, whole.value, 1e-12);
}

// Beside p^2 = 1, which the known state leads to, p^2 = 3.4 is stationary, and its short waves grow as (1.7 - 1) q^2.
TEST(ModelBoundary, OfTheLargestOrderIsFoundBesideAKnownOne) {
    const model::Equations equations(
        {.fields = {spin(1, "p", "(1 - p.p) ((p.p - 3)^2 - 0.16) p + lap p - 0.5 p.p lap p")},
         .definitions = {},
         .coefficients = {}});
    const GrowthSearch search{.min = 1e-2, .max = 10.0, .wavenumbers = 31, .angles = 12};
    const Margin found = margin(equations, MarginState::ordered, {.values = {{1.0, 0.0}}, .ordered = 1}, search);
    // Across the order, which turns without decay, the rate is .7 q^2 exactly; q = max grows fastest.
    EXPECT_NEAR(found.value, -0.7 * (search.max * search.max + search.min * search.max), 1e-9);
}

/// The margin with each of `count` draws of a number.
template <class MarginWith>
std::vector<MarginOf> drawn(MarginWith margin_with, double value, double error, std::size_t count,
                            std::uint64_t number = 0) {
    std::vector<MarginOf> margins;
    for (const double normal : normal_draws(random_ranks(number, 0, count)))
        margins.emplace_back([=, here = value + normal * error](const numerics::PlanePoint& point) {
            return Margin{.value = margin_with(point, here)};
        });
    return margins;
}

// The Turing line b = (1 + a sqrt(Du/Dv))^2, at fixed a, with Du = 5.0(3).
TEST(ModelBoundaryLong, MovesByTheErrorOfACoefficient) {
    Threads threads(1);
    std::vector<MarginOf> draws;
    for (const double normal : normal_draws(random_ranks(0, 0, 40)))
        draws.push_back(plane_of(brusselator(), "a", "b", MarginState::isotropic, "Du", 0.3 * normal));
    const Boundary found = trace_boundary({.x0 = 3.1, .x1 = 4.0, .y0 = 8.0, .y1 = 13.2},
                                          plane_of(brusselator(), "a", "b", MarginState::isotropic), draws,
                                          {.cells = 26, .chord = 1e-2}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    const auto turing = [](double a, double diffusion) { return std::pow(1.0 + a * std::sqrt(diffusion / 12.0), 2.0); };
    for (const BoundaryPoint& point : found.lines[0].points) {
        if (turing(point.x, 5.6) > 1.0 + point.x * point.x || point.y > 12.0) continue;  // oscillations, and the edge
        // 40 draws know a share to 1/80, which is 0.05 standard deviations at one of them; cells are 0.2 wide in b, and
        // the share is a straight line there to some per cent of the error.
        const double error = 0.5 * (turing(point.x, 5.3) - turing(point.x, 4.7));
        EXPECT_NEAR(point.band.y_low, turing(point.x, 4.7), 0.15 * error) << point.x;
        EXPECT_NEAR(point.band.y_high, turing(point.x, 5.3), 0.15 * error) << point.x;
    }
}

// The line x = c + c^3/2 of a number c that is measured with the error 0.05: the band about the line of the measured
// value holds the true line as often as the measured value lies within one error of the true one.
TEST(BandStatistics, CoversTheTrueLineAsOftenAsOneStandardErrorDoes) {
    Threads threads(1);
    const auto line_of = [](double c) { return c + 0.5 * c * c * c; };
    const auto margin_with = [=](const numerics::PlanePoint& point, double c) { return point.x - line_of(c); };
    constexpr double truth = 0.5, error = 0.05;
    constexpr std::size_t tables = 4000;
    std::vector<double> normal(tables);
    fill_normal({.seed = 7, .stream = Stream::test}, 0, 1, normal);
    int covered = 0;
    for (std::size_t table = 0; table < tables; ++table) {
        const double measured = truth + error * normal[table];
        const Boundary found = trace_boundary(
            {}, [=](const numerics::PlanePoint& point) { return Margin{.value = margin_with(point, measured)}; },
            drawn(margin_with, measured, error, 40, table), {.cells = 16, .chord = 0.1}, on_threads(threads));
        ASSERT_EQ(found.lines.size(), 1U);
        const BoundaryPoint& point = found.lines[0].points.front();
        ASSERT_TRUE(std::isfinite(point.band.x_low) && std::isfinite(point.band.x_high));
        covered += point.band.x_low < line_of(truth) && line_of(truth) < point.band.x_high;
    }
    // 68.3 %; the binomial deviation is 0.74 % of 4000, and 2 % are 2.7 of them; the tables are always the same.
    EXPECT_NEAR(static_cast<double>(covered) / tables, 0.683, 0.02);
}

// A parabola that opens upwards, y = 4 (x - 1/2)^2 + c with c = 0.3(1): a line through the points of a band to first
// order would leave the plane beside the fold.
TEST(Band, OfAFoldIsWhereDrawsDifferAndStaysInThePlane) {
    Threads threads(1);
    const auto margin_with = [](const numerics::PlanePoint& point, double c) {
        return 4.0 * (point.x - 0.5) * (point.x - 0.5) + c - point.y;
    };
    constexpr std::size_t count = 200;
    const Boundary found = trace_boundary(
        {}, [=](const numerics::PlanePoint& point) { return Margin{.value = margin_with(point, 0.3)}; },
        drawn(margin_with, 0.3, 0.1, count), {.cells = 40}, on_threads(threads));
    ASSERT_TRUE(found.field.has_value());
    EXPECT_EQ(found.field->draws, count);
    const int side = found.field->side;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            const numerics::PlanePoint point{static_cast<double>(i) / (side - 1), static_cast<double>(j) / (side - 1)};
            const double exact = margin_with(point, 0.3) / 0.1;
            const auto node = static_cast<std::size_t>(j * side + i);
            // A share is known to half a draw: 0.0025/0.054 standard deviations at two of them.
            if (std::abs(exact) < 2.0) {
                EXPECT_NEAR(found.field->deviation[node], exact, 0.05);
                EXPECT_NEAR(found.field->share[node], 0.5 * std::erfc(exact / std::numbers::sqrt2), 0.0026);
            } else {
                EXPECT_GT(found.field->deviation[node] * std::copysign(1.0, exact), 1.9);
            }
        }
    for (const BoundaryLine& line : found.lines)
        for (const BoundaryPoint& point : line.points) {
            EXPECT_FALSE(point.band.x_low < 0.0 || point.band.x_low > point.x || point.band.x_high > 1.0 ||
                         point.band.x_high < point.x);
            EXPECT_FALSE(point.band.y_low < 0.0 || point.band.y_low > point.y || point.band.y_high > 1.0 ||
                         point.band.y_high < point.y);
            // Cells are 0.025 wide, and straight lines between the 0.05 of above.
            if (point.y > 0.15 && point.y < 0.85) {
                EXPECT_NEAR(point.band.y_high - point.band.y_low, 0.2, 0.012);
            }
        }
    EXPECT_DOUBLE_EQ(found.field->with_line, 1.0);
    EXPECT_DOUBLE_EQ(found.field->with_more, 0.0);
}

// y = min(c, h(x)) with c = 0.5(1) and an exact h = 0.2 + 0.6 x: beyond h all draws are unstable by the same amount.
TEST(Band, BesideALineWithoutErrorsKeepsItsWidth) {
    Threads threads(1);
    const auto exact = [](double x) { return 0.2 + 0.6 * x; };
    const auto margin_with = [=](const numerics::PlanePoint& point, double c) {
        return std::min(c, exact(point.x)) - point.y;
    };
    const Boundary found = trace_boundary(
        {}, [=](const numerics::PlanePoint& point) { return Margin{.value = margin_with(point, 0.5)}; },
        drawn(margin_with, 0.5, 0.1, 200), {.cells = 8}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    int both = 0;
    for (const BoundaryPoint& point : found.lines[0].points) {
        if (std::abs(exact(point.x) - 0.4) < 0.02) continue;  // where a share of 16 % meets the exact line
        // Edges are found to a tenth of the error, and jumps to a 64th of the cells, which are 0.125 wide.
        EXPECT_NEAR(point.band.y_low, std::min(0.4, exact(point.x)), 0.012) << point.x;
        EXPECT_NEAR(point.band.y_high, std::min(0.6, exact(point.x)), 0.012) << point.x;
        both += exact(point.x) > 0.62;
    }
    EXPECT_GT(both, 0);
}

// y = 4 (x - 1/2)^2 + c with c = 0.9(1) is in the plane for c < 1, in 84 % of the draws; a second island of radius^2
// -d = -0.01(1) is there in 16 %.
TEST(Band, CountsDrawsWithoutALineAndWithAnotherOne) {
    Threads threads(1);
    const auto parabola = [](const numerics::PlanePoint& point, double c) {
        return 4.0 * (point.x - 0.5) * (point.x - 0.5) + c - point.y;
    };
    const auto count_of = [&](auto margin_with, double value, double error) {
        return *trace_boundary(
                    {}, [=](const numerics::PlanePoint& point) { return Margin{.value = margin_with(point, value)}; },
                    drawn(margin_with, value, error, 200), {.cells = 40}, on_threads(threads))
                    .field;
    };
    // A line that passes less than a cell within the plane may be missed: 0.025 are a quarter of the error, 6 %.
    EXPECT_NEAR(count_of(parabola, 0.9, 0.1).with_line, 0.84, 0.06);
    const auto with_island = [&](const numerics::PlanePoint& point, double d) {
        const double x = point.x - 0.2, y = point.y - 0.2;
        return std::min(parabola(point, 0.5), x * x + y * y + d);
    };
    const DrawField field = count_of(with_island, 0.01, 0.01);
    EXPECT_DOUBLE_EQ(field.with_line, 1.0);
    // Islands smaller than a cell may be missed: their radius^2 is below 6e-4, 6 % of the error.
    EXPECT_NEAR(field.with_more, 0.16, 0.06);
}
}  // namespace
}  // namespace drover::theory::boundary_tests
