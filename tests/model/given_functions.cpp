// tests/model/given_functions.cpp: functions that are no formulas, terms with names of their own, point sources, and
// masses with a lower bound.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drover/model/linearised_at.hpp"
#include "model/explicit_part.hpp"

namespace drover::model::given_functions_tests {
namespace {

using numerics::Spectra;
constexpr numerics::Grid grid{.nx = 24, .ny = 20, .lx = 9.0, .ly = 7.0};

/// a^2 b, as a function that is no formula.
GivenFunction square_times() {
    return {.arguments = 2,
            .degree = 3,
            .values =
                [](std::size_t size, std::span<const PointArgument> at, std::span<double* const> out) {
                    const auto value = [&](std::size_t a, std::size_t i) {
                        return at[a].values ? at[a].values[i] : at[a].number;
                    };
                    for (std::size_t i = 0; i < size; ++i) out[0][i] = value(0, i) * value(0, i) * value(1, i);
                },
            .slopes =
                [](std::span<const double> at) {
                    return std::vector<double>{2.0 * at[0] * at[1], at[0] * at[0]};
                }};
}

/// A density and a vector whose equations use g, with an inertia that depends on the density.
Model with(const std::string& g, bool is_formula) {
    Model model;
    model.fields = {{.name = "n", .symbol = "n", .equation = {"-div(n v) + 0.2 lap n", {}}, .reference = 1.3},
                    {.name = "v",
                     .symbol = "v",
                     .spin = 1,
                     .mass = {"0.7 n", {}},
                     .equation = {"-G v + 0.1 lap v + 0.3 G v.grad n grad n", {}}}};
    model.definitions = {{"G", {"0.4 + " + g, {}}}};
    if (!is_formula) model.functions = {{"table", square_times()}};
    return model;
}

Spectra waves(int components) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    Spectra state(grid, components);
    const std::size_t width = numerics::columns(grid);
    for (int c = 0; c < components; ++c)
        for (const std::size_t mode : {std::size_t{1}, width + 1, width * 19 + 1})
            state[c][mode] = 0.05 * numerics::Complex(normal(random), normal(random));
    state[0][0] = 1.3;
    return state;
}

double difference(const Spectra& a, const Spectra& b) {
    double largest = 0.0, size = 0.0;
    for (std::size_t k = 0; k < a.values.size(); ++k) {
        largest = std::max(largest, std::abs(a.values[k] - b.values[k]));
        size = std::max(size, std::abs(a.values[k]));
    }
    return largest / size;
}

Spectra rate_of(const Equations& equations, const Spectra& state, double t = 0.0) {
    Threads threads(1);
    const numerics::System system = equations.system(grid, threads, 6);
    Spectra rate(grid, state.count());
    system.nonlinear(t, state, rate);
    return rate;
}

TEST(GivenFunctions, have_the_action_the_symbol_and_the_uniform_rates_of_the_equal_formula) {
    const Equations formula(with("n^2 (v.v)", true)), function(with("table(n, v.v)", false));
    EXPECT_LE(formula.degree(), function.degree());  // the degree of v.v counts for both arguments
    const Spectra state = waves(3);
    EXPECT_LT(difference(rate_of(formula, state), rate_of(function, state)), 1e-13);  // rounding
    const UniformState about{1.1, 0.3, -0.4};
    EXPECT_LT((formula.uniform_rates(about) - function.uniform_rates(about)).norm(), 1e-14);
    for (const numerics::Wavevector q : {numerics::Wavevector{0.0, 0.0}, {0.7, -0.4}})
        EXPECT_LT((formula.symbol(about, q) - function.symbol(about, q)).norm(), 1e-13);
    EXPECT_GT(LinearisedAt(function, about).whole({0.7, -0.4}).norm(), 0.1);
}

TEST(GivenFunctions, of_numbers_are_numbers) {
    const Equations formula(with("4 * 3", true)), function(with("table(2, 3)", false));
    const UniformState about{1.1, 0.3, -0.4};
    EXPECT_LT((formula.symbol(about, {0.7, 0.2}) - function.symbol(about, {0.7, 0.2})).norm(), 1e-14);
}

TEST(GivenFunctions, move_the_linear_part_with_the_state_about_which_it_is_taken) {
    const Equations function(with("table(n, 1)", false)), moved = function.about({0.9, 0.0, 0.0});
    Model other = with("table(n, 1)", false);
    other.fields[0].reference = 0.9;
    const numerics::Block expected = Equations(other).linear_system(grid, 6).linear(0.8).even,
                          found = moved.linear_system(grid, 6).linear(0.8).even;
    for (int i = 0; i < expected.size; ++i)
        for (int k = 0; k < expected.size; ++k) EXPECT_EQ(found(i, k), expected(i, k));
    EXPECT_EQ(moved.reference(), function.reference());
}

TEST(WrittenTerms, have_names_of_their_own) {
    Model plain, apart;
    plain.fields = apart.fields = {{.name = "p", .symbol = "p", .spin = 1, .equation = {"-p", {}}}};
    plain.fields[0].equation.text = "-p - 0.3 (p_x^2 e_x + p_y lap p_x e_y) + d_x div p e_x";
    const auto scope = std::make_shared<Scope>();
    scope->names = {{"order", "p"}, {"order_x", "p_x"}, {"order_y", "p_y"}};
    scope->parameters = {{"p", 0.3}};  // a name of the model
    apart.fields[0].further = {{.name = "mine",
                                .texts = {{"-p order_x^2 + grad_div_x order", {}}, {"-p order_y lap order_x", {}}},
                                .scope = scope}};
    const Equations one(plain), other(apart);
    EXPECT_EQ(other.terms().at(1).text, "mine");
    const UniformState about{0.4, -0.2};
    EXPECT_LT((one.symbol(about, {0.7, 0.2}) - other.symbol(about, {0.7, 0.2})).norm(), 1e-15);
    apart.fields[0].further[0].texts[0].text = "p order_z";
    EXPECT_THROW(Equations{apart}, Error);
}

TEST(PointSources, act_where_they_are_directly_and_through_a_field_in_balance) {
    // 0 = -2 u + lap u + f drives d_t p = u: f at a point that moves.
    Model model;
    model.fields = {
        {.name = "p", .symbol = "p", .spin = 1, .equation = {"-p + u + 0.5 f", {}}},
        {.name = "u", .symbol = "u", .spin = 1, .left = LeftSide::balance, .equation = {"-2 u + lap u + f", {}}},
        {.name = "f",
         .symbol = "f",
         .spin = 1,
         .left = LeftSide::given,
         .source = {.x = 0.8, .y = -0.3, .at_x = 1.0, .at_y = 2.0, .velocity_x = 0.5, .width = 0.4}}};
    const double t = 0.6;
    const Spectra rate = rate_of(Equations(model), Spectra(grid, 2), t);
    for (const auto& [i, j] : {std::pair{0u, 0u}, std::pair{1u, 2u}, std::pair{2u, 19u}}) {
        const numerics::Wavevector q = numerics::wavevector(grid, i, j);
        const double square = q.x * q.x + q.y * q.y;
        const numerics::Complex source =
            std::exp(-0.5 * 0.16 * square) / numerics::area(grid) * std::polar(1.0, -(q.x * 1.3 + q.y * 2.0));
        const double gain = 0.5 + 1.0 / (2.0 + square);
        const std::size_t mode = j * numerics::columns(grid) + i;
        EXPECT_LT(std::abs(rate[0][mode] - 0.8 * gain * source), 1e-15);
        EXPECT_LT(std::abs(rate[1][mode] + 0.3 * gain * source), 1e-15);
    }
}

TEST(Masses, have_a_lower_bound_for_a_step_where_their_drag_is_faster) {
    // m n d_t v = -G v: over a step of dt the mass is at least G dt, and at most half of m n at the reference.
    Model model;
    model.fields = {{.name = "n", .symbol = "n", .equation = {"lap n", {}}, .reference = 1.0},
                    {.name = "v", .symbol = "v", .spin = 1, .mass = {"2 n", {}}, .equation = {"-3 v", {}}}};
    Threads threads(1);
    const Equations equations(model);
    const numerics::System system = equations.linear_system(grid, 2);
    ExplicitPart part(equations, system, threads);
    EXPECT_EQ(part.mass_floor(1), 0.0);
    part.set_step(0.1);
    EXPECT_NEAR(part.mass_floor(1), 0.3 / 2.0, 1e-15);
    part.set_step(10.0);
    EXPECT_NEAR(part.mass_floor(1), 0.5, 1e-15);
    part.set_step(0.2);
    part.watch(0);
    Spectra state(grid, 3), rate(grid, 3);
    state[0][0] = 0.1;  // a mass of 0.2 under a floor of 0.6
    state[1][0] = 1.0;
    part(0.0, state, rate);
    const double mass = 0.2 * std::pow(1.0 + std::pow(3.0, 16.0), 1.0 / 16.0);
    EXPECT_NEAR(rate[1][0].real(), -3.0 / mass + 3.0 / 2.0, 1e-13);  // less the linear part
    EXPECT_NEAR(part.range(0).min, 0.1, 1e-15);
    EXPECT_NEAR(part.range(0).max, 0.1, 1e-15);
}

TEST(Masses, divide_forces_at_every_point_however_small_they_are) {
    // f/(n (1 + a cos x)) = f/(n sqrt(1 - a^2)) (1 + 2 sum of (-r)^k cos k x), r = (1 - sqrt(1 - a^2))/a.
    constexpr double f = 0.03, n = 0.1, a = 0.2;
    Model model;
    model.fields = {{.name = "n", .symbol = "n", .equation = {"lap n", {}}, .reference = 1.0},
                    {.name = "u", .symbol = "u", .mass = {"n", {}}, .equation = {"0.03 - u", {}}}};
    Threads threads(1);
    const Equations equations(model);
    const numerics::System system = equations.linear_system(grid, 2);
    ExplicitPart part(equations, system, threads);
    part.set_step(1e-3);  // the least mass for it, 0.001, is far below 0.08
    Spectra state(grid, 2), rate(grid, 2);
    state[0][0] = n;
    state[0][1] = 0.5 * a * n;
    part(0.0, state, rate);
    const double root = std::sqrt(1.0 - a * a), r = (1.0 - root) / a;
    for (std::size_t k = 0; k < 6; ++k)  // with the linear part about n = 1
        EXPECT_NEAR(rate[1][k].real() - f * state[0][k].real(), f / (n * root) * std::pow(-r, static_cast<double>(k)),
                    1e-14)
            << k;
}

TEST(GivenFunctions, that_are_not_complete_or_give_another_number_of_slopes_are_rejected) {
    const auto rejects = [](auto change) {
        Model model = with("table(n, n)", false);
        change(model.functions.at("table"));
        EXPECT_THROW(Equations{model}, Error);
    };
    rejects([](GivenFunction& f) { f.values = nullptr; });
    rejects([](GivenFunction& f) { f.slopes = nullptr; });
    rejects([](GivenFunction& f) { f.slopes = nullptr, f.has_exact_slopes = false; });
    for (const int results : {-1, 0, 3}) rejects([&](GivenFunction& f) { f.results = results; });
    for (const int arguments : {-1, 0}) rejects([&](GivenFunction& f) { f.arguments = arguments; });
    for (const std::size_t count : {0u, 1u, 3u})
        rejects([&](GivenFunction& f) { f.slopes = [=](auto) { return std::vector<double>(count); }; });
}

}  // namespace
}  // namespace drover::model::given_functions_tests
