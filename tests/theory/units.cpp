// tests/theory/units.cpp: the unit of one field changes no rate, no state and no fluctuation of another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "theory/models.hpp"
#include "theory/point_theory.hpp"

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

TEST(ModelUnits, of_order_change_neither_the_states_in_a_field_nor_that_it_turns_freely_without_one) {
    for (const double unit : {1.0, 1e-3, 1e-5, 1e-8, 1e5, 1e8}) {
        model::Model model{
            .fields = {spin(1, "p", "a p - b p.p p + h e_x + g e_y + lap p")},
            .coefficients = {{"a", 1.0}, {"b", 1.0 / (unit * unit)}, {"h", 0.05 * unit}, {"g", 0.03 * unit}}};
        const StationaryStates found = stationary_states(model::Equations(model));
        EXPECT_EQ(names(found),
                  (std::vector<std::string>{"along the field", "weakly against the field", "against the field"}))
            << unit;
        for (const StationaryState& state : found.states) EXPECT_FALSE(state.has_free_direction) << unit;
        model.coefficients.at("h") = model.coefficients.at("g") = 0.0;
        EXPECT_TRUE(turns_freely(model::Equations(model))) << unit;
    }
}

TEST(ModelUnits, of_length_change_no_direction_that_elasticity_names) {
    for (const double square : {1.0, 1e-12, 1e-16, 1e12, 1e16}) {
        model::Model model{.fields = {spin(1, "p", "a p - p.p p + k lap p - c d_y d_y p - k^2 lap lap p")},
                           .coefficients = {{"a", 1.0}, {"k", square}, {"c", 0.3 * square}}};
        EXPECT_FALSE(turns_freely(model::Equations(model))) << square;
        model.coefficients.at("c") = 0.0;
        EXPECT_TRUE(turns_freely(model::Equations(model))) << square;
    }
}

/// Toner and Tu's flock, with units of its own for the order and for lengths.
model::LinearisedAt flock_in(double unit, double length) {
    model::Model model{.fields = {scalar("n", "-u div p"),
                                  spin(1, "p", "(n - 1 - b p.p) p - w p.grad p + k lap p - c grad n")},
                       .coefficients = {{"u", length / unit},
                                        {"b", 1.0 / (unit * unit)},
                                        {"w", 0.7 * length / unit},
                                        {"k", length * length},
                                        {"c", unit * length}}};
    model.fields[0].conserved = true;
    model.fields[0].reference = 1.1;
    return about(model, 1);
}

TEST(ModelUnits, change_no_long_wave) {
    const model::LinearisedAt base = flock_in(1.0, 1.0);
    for (const auto& [unit, length] :
         {std::pair{0x1p25, 1.0}, {0x1p-25, 1.0}, {0x1p30, 0x1p-20}, {0x1p-10, 0x1p20}, {1.0, 0x1p-30}}) {
        const model::LinearisedAt other = flock_in(unit, length);
        for (const double angle : {0.0, 0.6, pi / 2.0}) {
            const std::vector<SlowMode> expected = slow_modes(base, angle).modes,
                                        found = slow_modes(other, angle).modes;
            ASSERT_EQ(found.size(), expected.size()) << unit << " " << length;
            for (std::size_t k = 0; k < found.size();
                 ++k) {  // rounding of numbers near 1, by gaps between speeds of 0.1
                EXPECT_LT(std::abs(found[k].speed / length - expected[k].speed), 1e-10) << unit << " " << length;
                EXPECT_LT(std::abs(found[k].damping / (length * length) - expected[k].damping), 1e-8)
                    << unit << " " << length;
            }
        }
    }
}

TEST(ModelUnits, of_order_change_no_state_on_its_axis) {
    for (const double size : {1.0, 1e6, 1e12, 1e20})
        for (const bool is_cubic : {true, false}) {
            const model::Equations equations(
                {.fields = {spin(1, "p", is_cubic ? "a p - b p.p p" : "a p - b (p.p)^2 p")},
                 .coefficients = {{"a", 0.2}, {"b", 0.2 / std::pow(size, is_cubic ? 2 : 4)}}});
            const PointTheory theory(equations);
            const std::optional<PointState> found =
                ordered_state(theory, equations.reference(), order_search(equations));
            ASSERT_TRUE(found) << size;
            EXPECT_NEAR(std::hypot(found->values[0], found->values[1]), size, 1e-12 * size);
            if (!is_cubic) continue;
            const std::optional<StationaryStates> both = states_of_cubic_order(theory, equations.reference());
            ASSERT_TRUE(both) << size;
            EXPECT_EQ(both->states.size(), 2u) << both->why_no_order;
        }
}

}  // namespace
}  // namespace drover::theory::units_tests
