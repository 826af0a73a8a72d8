// tests/theory/units.cpp: the unit of one field changes no rate, no state and no fluctuation of another.
#include <gtest/gtest.h>

#include <cmath>

#include "theory/models.hpp"

namespace drover::theory::units_tests {
namespace {

/// d_t (a, b) = ((-1, c), (-d, k)) (a, b), the unit of a being 1/unit of that in which c d is given.
model::LinearisedAt pair_in(double unit, double k, double product, double noise = 0.0) {
    model::Model model{.fields = {scalar("a", "-a + c b"), scalar("b", "k b - d a")},
                       .coefficients = {{"c", unit}, {"d", product / unit}, {"k", k}}};
    model.fields[1].noise = noise;
    return {model::Equations(model), {0.0, 0.0}};
}

TEST(ModelUnits, of_a_field_change_no_rate) {
    const double mean = -0.49, root = std::sqrt(mean * mean + 0.01);  // trace -0.98, determinant -0.01
    for (const double unit : {1.0, 1e6, 1e12, 1e-12, 1e15}) {
        const model::LinearisedAt at = pair_in(unit, 0.02, 0.01);
        for (const double q : {0.0, 0.7}) {
            const Modes found = modes(at, {q, 0.0});
            EXPECT_NEAR(found.rates(0).real(), mean + root, 1e-15) << unit;  // rounding of numbers of the size 1
            EXPECT_NEAR(found.rates(1).real(), mean - root, 1e-15) << unit;
            EXPECT_LT((found.duals * found.shapes - model::Symbol::Identity(2, 2)).norm(), 1e-14) << unit;
            EXPECT_LT(found.roundings(0), 1e-14) << unit;
            Complex sum = 0.0;
            for (const Complex share : term_shares(at, {q, 0.0})) sum += share;
            EXPECT_LT(std::abs(sum - found.rates(0)), 1e-14) << unit;
            EXPECT_TRUE(growth(at, q).grows()) << unit;
        }
    }
}

TEST(ModelUnits, of_a_field_change_no_structure_factor) {
    const double k = 1e-7, product = 1e-7, exact = 0.5 / (k + product / (1.0 + k + product));  // by elimination
    for (const double unit : {1.0, 1e4, 1e9, 1e12, 1e15}) {
        const Covariance found = covariance(pair_in(unit, -k, product, 1.0), {0.5, 0.0});
        ASSERT_EQ(found.why_none, "") << unit;
        EXPECT_NEAR(found.matrix(1, 1).real(), exact, 1e-8 * exact) << unit;  // rounding of 1 over rates of 1e-7
    }
}

TEST(ModelUnits, slow_fields_beside_fast_ones_grow_and_fluctuate_by_their_own_rates) {
    for (const double rate : {1e-8, -1e-8}) {
        model::Model model{.fields = {scalar("a", "-1e8 a + lap a"), scalar("b", "k b")},
                           .coefficients = {{"k", rate}}};
        for (model::Field& field : model.fields) field.noise = 2.0;
        const model::LinearisedAt at(model::Equations(model), {0.0, 0.0});
        EXPECT_EQ(growth(at, 0.3).grows(), rate > 0.0);
        EXPECT_DOUBLE_EQ(growth(at, 0.3).rate, rate);
        const Covariance found = covariance(at, {0.3, 0.0});
        EXPECT_EQ(found.why_none.empty(), rate < 0.0) << found.why_none;
        if (rate < 0.0) {
            EXPECT_DOUBLE_EQ(found.matrix(1, 1).real(), 1e8);  // D/(2 |k|)
        }
    }
}

TEST(ModelUnits, where_terms_of_one_field_cancel_its_rounding_errors_do_not_grow) {
    // The angle of a flock is neutral: a - b p^2 is a rounding error of a, of either sign.
    for (const double b : {0.3, 0.7, 1.1, 1.3, 1.7, 2.3}) {
        const model::LinearisedAt flock =
            about({.fields = {spin(1, "p", "(a - b p.p) p - grad div p")}, .coefficients = {{"a", 0.9}, {"b", b}}}, 1);
        EXPECT_FALSE(growth(flock, 0.0).grows()) << b;
    }
}

TEST(ModelUnits, of_a_field_change_no_state_of_saturation) {
    for (const double size : {1e-3, 1.0, 1e6, 1e12, 1e15, 1e20}) {  // g u = b u^3 at u = sqrt(g/b)
        const model::Model model{.fields = {scalar("u", "g u - b u^3 + lap u")},
                                 .coefficients = {{"g", 1.0}, {"b", 1.0 / (size * size)}}};
        const StationaryStates found = stationary_states(model::Equations(model));
        ASSERT_EQ(found.states.size(), 3u) << size << " " << found.why_none;
        for (const StationaryState& state : found.states) {
            if (state.values[0] == 0.0) continue;
            EXPECT_NEAR(std::abs(state.values[0]), size, 1e-12 * size);
        }
    }
}

TEST(ModelUnits, of_a_conserved_density_change_no_order) {
    for (const double number : {1.0, 1e6, 1e12, 1e24}) {
        model::Model model{.fields = {scalar("n", "-div(n v) + lap n"),
                                      spin(1, "v", "g v - b v.v v + lap v - e grad n")},
                           .coefficients = {{"g", 0.01}, {"b", 1e8}, {"e", 1e-10 / number}}};
        model.fields[0].reference = number;
        model.fields[0].conserved = true;
        const StationaryStates found = stationary_states(model::Equations(model));
        ASSERT_EQ(found.states.size(), 2u) << number << " " << found.why_none;
        EXPECT_NEAR(std::hypot(found.states[1].values[1], found.states[1].values[2]), 1e-5, 1e-17) << number;
        EXPECT_DOUBLE_EQ(found.states[1].values[0], number);
    }
}

}  // namespace
}  // namespace drover::theory::units_tests
