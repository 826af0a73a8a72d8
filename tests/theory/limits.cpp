// tests/theory/limits.cpp: states of largest order, limits of long waves and regimes of models of any fields.
#include "theory/limits.hpp"

#include <cmath>

#include "theory/models.hpp"

namespace drover::theory::limits_tests {
namespace {

double margin_of(const model::Model& model, Limit limit) {
    const model::Equations equations(model);
    return PointMargins(PointTheory(equations), equations.reference(), order_search(equations)).at(limit).value;
}

/// The order along x of the largest ordered state; NaN: there is none.
double order_of(const std::string& equation, std::map<std::string, double> coefficients) {
    model::Model model{.fields = {spin(1, "p", equation)}, .definitions = {}, .coefficients = std::move(coefficients)};
    const model::Equations equations(model);
    const auto found = ordered_state(PointTheory(equations), equations.reference(), order_search(equations));
    return found ? found->values[0] : NAN;
}

TEST(OrderedState, IsTheLargestRootOfTheRateOfOrder) {
    EXPECT_NEAR(order_of("a p - b |p|^2 p", {{"a", 0.3}, {"b", 0.7}}), std::sqrt(0.3 / 0.7), 1e-15);
    EXPECT_NEAR(order_of("a p - b |p|^2 p", {{"a", 3e7}, {"b", 0.7}}), std::sqrt(3e7 / 0.7), 1e-11);
    EXPECT_TRUE(std::isnan(order_of("-a p - b |p|^2 p", {{"a", 0.3}, {"b", 0.7}})));
    EXPECT_TRUE(std::isnan(order_of("a p", {{"a", 0.3}})));  // without bound
    // Subcritical: -a + b s - c s^2 = 0, and none where b^2 < 4 a c.
    const std::string subcritical = "-a p + b |p|^2 p - c |p|^4 p";
    EXPECT_NEAR(order_of(subcritical, {{"a", 0.3}, {"b", 1.4}, {"c", 0.9}}),
                std::sqrt((1.4 + std::sqrt(1.4 * 1.4 - 4.0 * 0.3 * 0.9)) / 1.8), 1e-14);
    EXPECT_TRUE(std::isnan(order_of(subcritical, {{"a", 0.3}, {"b", 1.0}, {"c", 0.9}})));
    // No polynomial, and convex in s: g/(1 + s) = a.
    EXPECT_NEAR(order_of("-a p + g p/(1 + |p|^2)", {{"a", 0.02}, {"g", 5.0}}), std::sqrt(5.0 / 0.02 - 1.0), 1e-12);
}

TEST(OrderedState, InAFieldIsTheRootOfTheCubicAlongIt) {
    model::Model model{.fields = {spin(1, "p", "p - |p|^2 p + h (0.6 e_x + 0.8 e_y)")},
                       .definitions = {},
                       .coefficients = {}};
    for (const double h : {1e-4, 0.3, 5.0, -0.3}) {
        model.coefficients["h"] = h;
        const model::Equations equations(model);
        const auto found = ordered_state(PointTheory(equations), equations.reference(), order_search(equations));
        ASSERT_TRUE(found);
        const double order = 0.6 * found->values[0] + 0.8 * found->values[1], size = std::abs(order);
        EXPECT_NEAR(size * size * size - size, std::abs(h), 1e-14 * (1.0 + std::abs(h)));
        EXPECT_GT(order * h, 0.0);
        EXPECT_NEAR(std::hypot(found->values[0], found->values[1]), size, 1e-14);
        EXPECT_TRUE(std::isnan(margin_of(model, Limit::onset)));  // nothing sets in
    }
}

TEST(OrderedState, OfEquationsThatNameADirectionIsFoundByTheWholeSearch) {
    // Along y order is larger: p_y^2 = 1, p_x^2 = 0.4.
    const model::Model model{.fields = {spin(1, "p", "p - |p|^2 p - 0.6 p.e_x e_x")},
                             .definitions = {},
                             .coefficients = {}};
    const model::Equations equations(model);
    const OrderSearch search = order_search(equations);
    EXPECT_TRUE(search.is_whole);
    const auto found = ordered_state(PointTheory(equations), equations.reference(), search);
    ASSERT_TRUE(found);
    EXPECT_NEAR(std::abs(found->values[1]), 1.0, 1e-12);
}

/// Order that a flow turns, a flow that the order drives: with inertia or without.
model::Model driven(bool has_inertia, double decay) {
    model::Field flow = spin(1, "v", "-G v + k p");
    if (has_inertia) flow.mass = {"m", {}};
    else flow.left = model::LeftSide::balance;
    return {.fields = {flow, spin(1, "p", "-a p - b |p|^2 p + l v")},
            .definitions = {},
            .coefficients = {{"G", 2.0}, {"k", 1.5}, {"a", decay}, {"b", 0.8}, {"l", 0.6}, {"m", 0.3}}};
}

TEST(Onset, OfOrderThatAFlowTurnsIsWhereItsEffectiveDecayVanishes) {
    for (const bool has_inertia : {true, false})
        for (const double decay : {0.2, 0.9}) {
            model::Model model = driven(has_inertia, decay);
            model.fields[0].observed.drawn = 2;
            model.fields[1].observed.drawn = 1;  // the order
            EXPECT_NEAR(margin_of(model, Limit::onset), decay - 0.6 * 1.5 / 2.0, 1e-15) << has_inertia;
        }
}

/// Rods alone: a = a0 - c sigma.
model::Model rods(double sigma) {
    model::Field density = scalar("s", "-div p"),
                 order = spin(1, "p", "-(a - c s) p - b |p|^2 p - w p.grad p + K lap p - B grad s");
    density.conserved = true;
    density.reference = sigma;
    return {.fields = {density, order},
            .definitions = {},
            .coefficients = {{"a", 1.0}, {"c", 0.8}, {"b", 0.7}, {"w", 0.5}, {"K", 0.9}, {"B", 0.6}}};
}

TEST(Banding, OfAModelOfAnyFieldsBeginsAtItsClosedForm) {
    // |abar| = c^2/(4 b B + 2 w c), abar = a - c sigma.
    const double onset = 1.0 / 0.8, threshold = onset + 0.8 / (4.0 * 0.7 * 0.6 + 2.0 * 0.5 * 0.8);
    double low = onset + 1e-3, high = onset + 3.0;
    ASSERT_LT(margin_of(rods(low), Limit::banding), 0.0);
    ASSERT_GT(margin_of(rods(high), Limit::banding), 0.0);
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (margin_of(rods(middle), Limit::banding) < 0.0 ? low : high) = middle;
    }
    EXPECT_NEAR(low, threshold, 1e-10);
    // Waves a little off the order are like those along it.
    EXPECT_LT(margin_of(rods(threshold - 1e-3), Limit::oblique), 0.0);
    EXPECT_NEAR(margin_of(rods(1.0), Limit::onset), 0.2, 1e-15);
    EXPECT_TRUE(std::isnan(margin_of(rods(1.0), Limit::banding)));
    EXPECT_GT(margin_of(rods(1.0), Limit::phase_separation), 0.0);
}

TEST(PhaseSeparation, WithoutAnOrderIsTheSpinodal) {
    for (const double part : {0.99, 1.01}) {
        model::Field phi = scalar("phi", "lap(phi^3 - phi - lap phi)");
        phi.conserved = true;
        phi.reference = part / std::sqrt(3.0);
        const model::Model model{.fields = {phi}, .definitions = {}, .coefficients = {}};
        EXPECT_NEAR(margin_of(model, Limit::phase_separation), part * part - 1.0, 1e-14);
    }
}

TEST(Regime, FollowsFromTheSignsOfTheMargins) {
    const auto of = [](double onset, double separation, double banding, double oblique) {
        return regime_of([=](Limit limit) {
            return limit == Limit::onset              ? onset
                   : limit == Limit::phase_separation ? separation
                   : limit == Limit::banding          ? banding
                                                      : oblique;
        });
    };
    EXPECT_EQ(of(NAN, NAN, NAN, NAN), Regime::undefined);
    EXPECT_EQ(of(1.0, 1.0, NAN, NAN), Regime::isotropic);
    EXPECT_EQ(of(1.0, -1.0, NAN, NAN), Regime::separating);
    EXPECT_EQ(of(-1.0, NAN, NAN, NAN), Regime::undefined);
    EXPECT_EQ(of(-1.0, NAN, 1.0, 1.0), Regime::flock);
    EXPECT_EQ(of(-1.0, NAN, -1.0, -1.0), Regime::banding);
    EXPECT_EQ(of(-1.0, NAN, 1.0, -1.0), Regime::oblique);
    EXPECT_TRUE(regime_legend().starts_with("-1 not defined, 0 isotropic, "));
}

}  // namespace
}  // namespace drover::theory::limits_tests
