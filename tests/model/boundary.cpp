// tests/model/boundary.cpp: margins of stability and their lines against exact ones.
#include "drover/model/boundary.hpp"

#include <algorithm>
#include <cmath>

#include "theory_models.hpp"

namespace drover::model::boundary_tests {
namespace {
/// The model with two coefficients as the axes of a plane, and the margin of a state.
MarginOf plane_of(const Model& model, const std::string& x, const std::string& y, MarginState state,
                  const std::string& changed = {}, double by = 0.0) {
    std::vector<UniformState> guesses;
    for (const StationaryState& known : stationary_states(Equations(model)).states) guesses.push_back(known.values);
    return [=](const numerics::PlanePoint& point, const Margin* wave) {
        Model at = model;
        at.coefficients[x] = point.x;
        at.coefficients[y] = point.y;
        if (!changed.empty()) at.coefficients[changed] += by;
        return margin(Equations(at), state, guesses, {.min = 1e-2, .max = 10.0, .wavenumbers = 31, .angles = 12}, wave);
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

Model brusselator() {
    Field u = scalar("u", "a - (b + 1) u + u^2 v + Du lap u"), v = scalar("v", "b u - u^2 v + Dv lap v");
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
            EXPECT_NEAR(std::abs(point.at.frequency), point.x, 1e-6);
        }
    }
    EXPECT_GT(waves, 3);
    EXPECT_GT(oscillations, 3);
}

// A conserved density: d_t phi = lap(r phi + phi^3 - lap phi) separates where r + 3 phi0^2 < 0, first in long waves.
TEST(ModelBoundary, OfPhaseSeparationIsThatOfTheLongestWaves) {
    Threads threads(1);
    const MarginOf margin = [](const numerics::PlanePoint& point, const Margin* wave) {
        Field phi = scalar("phi", "lap(r phi + phi^3 - lap phi)");
        phi.conserved = true;
        phi.reference = point.y;
        const Model model{.fields = {phi}, .definitions = {}, .coefficients = {{"r", point.x}}};
        return model::margin(Equations(model), MarginState::isotropic, {},
                             {.min = 1e-2, .max = 10.0, .wavenumbers = 31}, wave);
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
    const Model model{.fields = {spin(1, "p", "(m - p.p - phi^2) p + lap p"),
                                 scalar("phi", "(k - p.p) phi - phi^3 + lap phi")},
                      .definitions = {},
                      .coefficients = {{"m", 1.0}, {"k", 0.5}}};
    const Boundary found =
        trace_boundary({.x0 = 0.2, .x1 = 1.0, .y0 = 0.1, .y1 = 1.5}, plane_of(model, "m", "k", MarginState::ordered),
                       {}, {.cells = 1, .chord = 0.2}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    EXPECT_LT(farthest(found, [](double m) { return m; }), 1e-9);
    EXPECT_TRUE(std::isnan(plane_of(model, "m", "k", MarginState::ordered)({-0.2, 0.5}, nullptr).value));
}

// The Turing line moves with Du: db = (1 + a r) a r/Du dDu with r = sqrt(Du/Dv), at fixed a.
TEST(ModelBoundary, MovesByTheErrorOfACoefficient) {
    Threads threads(1);
    const MarginState state = MarginState::isotropic;
    const UncertainMargin uncertain = [&](double part) {
        return plane_of(brusselator(), "a", "b", state, "Du", part * 0.3);
    };
    const Boundary found =
        trace_boundary({.x0 = 2.5, .x1 = 4.0, .y0 = 5.0, .y1 = 13.0}, plane_of(brusselator(), "a", "b", state),
                       {uncertain}, {.cells = 4, .chord = 1e-2}, on_threads(threads));
    ASSERT_EQ(found.lines.size(), 1U);
    const double ratio = std::sqrt(5.0 / 12.0);
    for (const BoundaryPoint& point : found.lines[0].points) {
        const double by_x = point.error_x / 1.5, by_y = point.error_y / 8.0;
        const double along_y = (by_x * by_x + by_y * by_y) / std::abs(by_y) * 8.0;
        const double expected = (1.0 + point.x * ratio) * point.x * ratio / 5.0 * 0.3;
        EXPECT_NEAR(along_y, expected, 1e-4 * expected) << point.x;  // slopes by differences of 1e-6
    }
}
}  // namespace
}  // namespace drover::model::boundary_tests
