// tests/model/right_hand_side.cpp: the explicit part: the same bytes at every call and with any number of threads.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "drover/model/equations.hpp"

namespace drover::model::right_hand_side_tests {
namespace {

using numerics::Complex;
using numerics::Spectra;

Model model_of(std::vector<Field> fields) {
    return {.fields = std::move(fields), .coefficients = {{"a", 0.7}, {"b", -0.4}}};
}
/// A velocity in balance that no field drives; of the fields; linear terms that name an axis; position and time.
std::vector<Model> models() {
    const Field density{.name = "density",
                        .symbol = "sigma",
                        .equation = {"-div(sigma v) + 0.1 lap sigma", {}},
                        .reference = 1.0};
    const Field order{.name = "order", .symbol = "p", .spin = 1, .equation = {"p - p.p p - p.grad p", {}}};
    const Field driven{.name = "velocity",
                       .symbol = "v",
                       .spin = 1,
                       .left = LeftSide::balance,
                       .equation = {"p - grad sigma - v + lap v + b e_y", {}}};
    Field undriven = driven, skewed = order, placed = order;
    undriven.equation = {"a e_x - v", {}};
    skewed.equation = {"-div(p) e_x + d_x d_y p + p.p e_y + d_x d_x d_x d_x d_x p", {}};
    placed.equation = {"cos(x + t) p - sin(y)^2 p.p p", {}};
    return {model_of({density, order, undriven}), model_of({density, order, driven}), model_of({skewed}),
            model_of({placed})};
}

Spectra random_state(const numerics::Grid& grid, int components) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    Spectra state(grid, components);
    const std::size_t width = numerics::columns(grid), rows = grid.ny == 1 ? 1 : 3;
    for (int c = 0; c < components; ++c)
        for (std::size_t j = 0; j < rows; ++j)
            for (std::size_t i = 1; i < 4; ++i) state[c][j * width + i] = Complex(normal(random), normal(random));
    return state;
}

TEST(ModelRightHandSide, has_the_same_bytes_at_every_call_and_with_any_number_of_threads) {
    for (const numerics::Grid& grid : {numerics::Grid{.nx = 48, .ny = 40, .lx = 9.0, .ly = 7.0},
                                       numerics::Grid{.nx = 1200, .ny = 1, .lx = 9.0, .ly = 1.0}})
        for (const Model& model : models()) {
            const Equations equations(model);
            const Spectra state = random_state(grid, static_cast<int>(equations.state_components().size()));
            Spectra expected(grid, state.count());
            for (const int count : {1, 2, 3}) {
                Threads threads(count);
                const numerics::System system = equations.system(grid, threads);
                for (int call = 0; call < 2; ++call) {
                    Spectra rate(grid, state.count());
                    system.nonlinear(0.25, state, rate);
                    if (count == 1 && call == 0) expected = rate;
                    EXPECT_EQ(rate.values, expected.values)
                        << model.fields[0].equation.text << ", " << count << " threads, call " << call;
                }
            }
        }
}

TEST(ExplicitRate, is_the_fastest_rate_of_linear_terms_that_name_an_axis_or_depend_on_position_or_time) {
    const double side = 2.0 * std::numbers::pi;
    const numerics::Grid grid{.nx = 48, .ny = 48, .lx = side, .ly = side};
    const auto rate = [&](std::vector<Field> fields, double t = 0.0) {
        return Equations(model_of(std::move(fields))).explicit_rate(grid, t);
    };
    const auto of_scalar = [&](const char* equation, double t = 0.0) {
        return rate({{.name = "s", .symbol = "s", .equation = {equation, {}}, .reference = 0.5}}, t);
    };
    // The largest mode numbers on an axis that are kept, below 48/(degree + 1); of cos(x) lap s the degree is 3.
    const double q = 23.0, degree_2 = 15.0, degree_3 = 11.0;
    EXPECT_EQ(of_scalar("a lap s - b lap lap s"), 0.0);
    EXPECT_NEAR(of_scalar("s - s^2 + lap(s^2)"), 0.0, 1e-12 * degree_2 * degree_2);  // rounding of 2 s - 2 (1/2)
    // The propagator has the average over directions, -a q^2 / 2.
    EXPECT_NEAR(of_scalar("a d_x d_x s"), 0.7 * q * q / 2.0, 1e-12 * q * q);
    EXPECT_NEAR(of_scalar("(1 + a cos(x)) lap s"), 1.7 * 2.0 * degree_3 * degree_3, 1e-12 * q * q);
    EXPECT_NEAR(of_scalar("cos(t) lap s", 1.0), std::cos(1.0) * 2.0 * q * q, 1e-12 * q * q);
    EXPECT_NEAR(
        rate({{.name = "s", .symbol = "s", .equation = {"-cos(t) div v", {}}},
              {.name = "v", .symbol = "v", .spin = 1, .left = LeftSide::balance, .equation = {"-grad s - v", {}}}}),
        2.0 * q * q, 1e-12 * q * q);
}

}  // namespace
}  // namespace drover::model::right_hand_side_tests
