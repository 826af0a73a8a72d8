// tests/physics/function_terms.cpp: functions of the calling program as terms, against the same terms as text.
#include "physics/program_functions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "linear_modes.hpp"
#include "physics/rod_bead_model.hpp"
#include "symbols.hpp"
#include "text_terms.hpp"

namespace drover::physics::function_terms_tests {
namespace {

/// A function of one point: its arguments to the two components.
using AtPoint = std::function<std::array<double, 2>(const std::vector<double>&)>;

TextTerm function_term(const std::string& of, std::vector<std::string> arguments, int degree, const AtPoint& at) {
    TextTerm term{.of = of, .where = {}, .function = "tried", .arguments = std::move(arguments), .degree = degree};
    term.call = std::make_shared<const PointFunction>(
        [at](std::size_t size, std::span<const PointArgument> given, std::span<double* const> out) {
            for (std::size_t i = 0; i < size; ++i) {
                std::vector<double> values;
                for (const PointArgument& one : given) values.push_back(one.values ? one.values[i] : one.number);
                const std::array<double, 2> found = at(values);
                out[0][i] = found[0];
                out[1][i] = found[1];
            }
        });
    return term;
}

Model flock() {
    return {.uniform = {.rod_density = 1.5},
            .current = {.speed = 1.0},
            .relaxation = {.rate = -1.0, .saturation = 1.0},
            .elasticity = {.stiffness = 0.5, .splay = 0.2},
            .pressure = {.rods = 0.5}};
}

Model with(TextTerm term) {
    Model model = flock();
    model.parameters = {{"W", 0.7}};
    model.text_terms = {std::move(term)};
    return model;
}

UniformPoint state(double order_x, double order_y) {
    return {.bead_density = 1.0, .rod_density = 1.3, .order = {order_x, order_y}};
}

// Differences extrapolated from two steps of a smooth function: 1e-8 of the fourth step^4, or rounding, 1e-13.
TEST(FunctionTerms, have_the_linearisation_and_the_rates_of_the_equal_text) {
    const Model text = with(text_term("order", {"-W tanh(order_x) rod_density^2", "W order_y lap order_x"}));
    const Model function =
        with(function_term("order", {"order_x", "order_y", "rod_density", "lap_order_x", "W"}, 0, [](const auto& a) {
            return std::array{-a[4] * std::tanh(a[0]) * a[2] * a[2], a[4] * a[1] * a[3]};
        }));
    const Equations one(function), other(text);
    for (const UniformPoint& point : {state(0.0, 0.0), state(0.8, -0.3)})
        for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{0.4, 0.9}, std::pair{-2.0, 1.0}})
            EXPECT_LT((force_symbol(one, point, {.x = x, .y = y}) - force_symbol(other, point, {.x = x, .y = y}))
                          .cwiseAbs()
                          .maxCoeff(),
                      1e-9);
    EXPECT_LT((uniform_rates(one, state(0.8, -0.3)) - uniform_rates(other, state(0.8, -0.3))).cwiseAbs().maxCoeff(),
              1e-14);
}

// A flux of second derivatives is of third degree in q: it changes no speed and no damping of long waves.
TEST(FunctionTerms, and_texts_with_a_flux_of_second_derivatives_leave_long_waves_as_they_are) {
    const auto third = [](const auto& a) { return std::array{0.4 * a[0], 0.4 * a[1]}; };
    const Equations plain(flock());
    const StationaryStates states = stationary_states(plain);
    const std::vector<SlowMode> expected = slow_modes(long_waves(plain, states.states.back()), 0.7);
    ASSERT_FALSE(expected.empty());
    for (const TextTerm& term : {text_term("rod_density", {}, {"0.4 lap order_x", "0.4 lap order_y"}),
                                 function_term("rod_density", {"lap_order_x", "lap_order_y"}, 1, third)}) {
        Model model = flock();
        model.text_terms = {term};
        const Equations equations(model);
        const std::vector<SlowMode> found = slow_modes(long_waves(equations, states.states.back()), 0.7);
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_LT(std::abs(found[i].speed - expected[i].speed), 1e-9);
            EXPECT_LT(std::abs(found[i].damping - expected[i].damping), 1e-7);
        }
    }
}

TEST(FunctionTerms, are_refused_where_the_program_does_not_have_them) {
    TextTerm term = function_term("order", {"order_x"}, 1, {});
    term.call = nullptr;
    EXPECT_THAT(missing_function(with(term)), ::testing::HasSubstr("terms[1] is the Python function tried"));
    EXPECT_THROW(check(with(term)), Error);
    EXPECT_NO_THROW(Equations{with(term)});  // readers of archives need the fields and the degree
    EXPECT_EQ(missing_function(flock()), "");
}

TEST(FunctionTerms, must_be_polynomials_of_the_degree_that_they_declare) {
    const auto cube = [](const auto& a) { return std::array{a[0] * a[0] * a[0], 0.0}; };
    EXPECT_THROW(check(with(function_term("order", {"order_x"}, 2, cube))), Error);
    EXPECT_NO_THROW(check(with(function_term("order", {"order_x"}, 3, cube))));
    EXPECT_NO_THROW(check(with(function_term("order", {"order_x"}, 5, cube))));
}

}  // namespace
}  // namespace drover::physics::function_terms_tests
