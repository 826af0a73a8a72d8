// tests/theory/states.cpp: the uniform states of declared models beside exact roots.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "theory/models.hpp"

namespace drover::theory::theory_states_tests {
namespace {

TEST(ModelStates, of_a_bistable_scalar_are_three_and_two_of_them_are_stable) {
    const model::Equations equations(model::Model{.fields = {scalar("phi", "phi - phi^3 + lap phi")}});
    const StationaryStates found = stationary_states(equations);
    EXPECT_EQ(names(found),
              (std::vector<std::string>{"isotropic: phi = -1", "isotropic: phi = 0", "isotropic: phi = 1"}));
    for (const auto& [state, rate] : {std::pair{0, -2.0}, {1, 1.0}, {2, -2.0}}) {
        const StationaryState& here = found.states.at(static_cast<std::size_t>(state));
        EXPECT_TRUE(here.is_isotropic);
        EXPECT_FALSE(here.has_free_direction || here.is_of_family);
        EXPECT_LE(here.residual, 1e-12);
        EXPECT_NEAR(growth(model::LinearisedAt(equations, here.values), 0.0).rate, rate, 1e-13);  // 1 - 3 phi^2
    }
}

TEST(ModelStates, of_a_quintic_scalar_are_all_its_roots_far_from_the_starting_points_of_the_search) {
    const model::Equations equations(model::Model{
        .fields = {scalar("phi", "-1e-3 (phi - 0.011)(phi + 0.07)(phi - 0.9)(phi - 0.97)(phi - 40) + lap phi")}});
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 5u);
    const std::vector<double> roots{-0.07, 0.011, 0.9, 0.97, 40.0};
    // Rounding of the products over the slope: cancellation in the factor of the root itself, some units in 1e-16.
    for (std::size_t k = 0; k < roots.size(); ++k) EXPECT_NEAR(found.states[k].values[0], roots[k], 1e-14 * 40.0);
}

TEST(ModelStates, of_a_scalar_are_all_its_roots_whatever_its_unit) {
    for (const double unit : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const auto& [low, high] : {std::pair{1.0, 2.0}, {30.0, 60.0}, {-0.2, 0.05}}) {
            const model::Equations equations(
                model::Model{.fields = {scalar("c", "(c - 1e-3 U)(c - l U)(h U - c)/U^2 + lap c")},
                             .coefficients = {{"U", unit}, {"l", low}, {"h", high}}});
            const StationaryStates found = stationary_states(equations);
            ASSERT_EQ(found.states.size(), 3u) << unit << " " << low;
            std::vector<double> roots{1e-3 * unit, low * unit, high * unit};
            std::sort(roots.begin(), roots.end());
            // Cancellation in the factor of a root, as above; Newton's last step is 1e-15 of the root.
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_NEAR(found.states[k].values[0], roots[k], 1e-14 * std::abs(high) * unit) << unit << " " << low;
        }
}

TEST(ModelStates, of_independent_fields_are_all_combinations_or_the_search_says_that_there_may_be_others) {
    const auto bistable = [](const std::string& symbol) {
        return scalar(symbol, text("{0} - {0}^3 + lap {0} + 0.02", symbol));
    };
    const StationaryStates few =
        stationary_states(model::Equations(model::Model{.fields = {bistable("a"), bistable("b"), bistable("c")}}));
    EXPECT_EQ(few.states.size(), 27u);
    EXPECT_EQ(few.why_incomplete, "");
    // Six have 3^6 = 729 states.
    const StationaryStates many = stationary_states(model::Equations(model::Model{
        .fields = {bistable("a"), bistable("b"), bistable("c"), bistable("d"), bistable("f"), bistable("g")}}));
    EXPECT_TRUE(many.states.size() == 729 || many.why_incomplete != "") << many.states.size();
    EXPECT_GT(many.states.size(), 27u);
}

TEST(ModelStates, at_kinks_and_jumps_have_no_linear_theory) {
    const auto of = [](const std::string& rate) {
        return stationary_states(model::Equations(model::Model{.fields = {scalar("c", rate + " + lap c")}}));
    };
    for (const char* const rate : {"-c + 3 abs(c)", "-c + 3 max(c, 0)"}) {  // 2 c for c > 0: unstable
        const StationaryStates found = of(rate);
        EXPECT_TRUE(found.states.empty()) << rate;
        EXPECT_NE(found.why_none.find("all fields 0 is stationary, but a term has no derivative"), std::string::npos);
    }
    for (const char* const rate : {"-c + sign(c)", "-c + c/abs(c)"}) {
        const StationaryStates found = of(rate);
        EXPECT_EQ(names(found), (std::vector<std::string>{"isotropic: c = -1", "isotropic: c = 1"})) << rate;
    }
    EXPECT_EQ(names(of("-c + sqrt(c)")), (std::vector<std::string>{"isotropic"}));  // c = 1
    EXPECT_FALSE(of("-c + sqrt(c)").kink.empty());
    const StationaryStates smooth = of("-c + abs(c) c");  // whose derivative at 0 is that of -c
    EXPECT_EQ(smooth.states.size(), 3u);
    EXPECT_TRUE(smooth.kink.empty());
    const model::Equations beside(model::Model{.fields = {scalar("c", "1 - max(c, 2) + lap c")}});
    for (const auto& [c, rate] : {std::pair{1.0, 0.0}, {3.0, -1.0}}) EXPECT_EQ(beside.symbol({c}, {})(0, 0), rate);
    EXPECT_THROW(static_cast<void>(beside.symbol({2.0}, {})), Error);
}

TEST(ModelStates, of_a_flock_are_one_isotropic_and_one_ordered_along_x_whose_copies_count_once) {
    const double a = -0.7, b = 0.4;
    const model::Equations equations(
        model::Model{.fields = {scalar("sigma", "-div(sigma p)"), spin(1, "p", "-(a + b p.p) p + lap p - grad sigma")},
                     .coefficients = {{"a", a}, {"b", b}}});
    const StationaryStates found = stationary_states(equations);
    EXPECT_EQ(names(found), (std::vector<std::string>{"isotropic", "ordered"}));
    EXPECT_FALSE(found.states[0].has_free_direction);
    EXPECT_TRUE(found.states[1].has_free_direction);
    EXPECT_FALSE(found.states[1].is_of_family);
    EXPECT_NEAR(found.states[1].values[1], std::sqrt(-a / b), 1e-14);
    EXPECT_EQ(found.states[1].values[2], 0.0);
}

TEST(ModelStates, with_a_field_that_only_decays_are_those_without_it) {
    // p^2 = a - l Q_xx with Q_xx (1 + Q_xx^2) = p^2/2; w decays to rounding errors, which are no reason against a root.
    model::Model model{.fields = {scalar("rho", "lap rho"), scalar("w", "curl p - w"),
                                  spin(1, "p", "a p - p.p p - l Q.p + w perp p"),
                                  spin(2, "Q", "sym(outer(p, p)) - Q - (Q:Q) Q / 2")},
                       .coefficients = {{"a", 0.48}, {"l", 0.2}}};
    model.fields[0].conserved = true;
    model.fields[0].reference = 0.8;
    model.fields[1].odd = true;
    const StationaryStates found = stationary_states(model::Equations(model));
    ASSERT_EQ(found.states.size(), 2u);
    const model::UniformState& flock = found.states[1].values;
    EXPECT_EQ(flock[1], 0.0);
    EXPECT_NEAR(flock[2] * flock[2], 0.48 - 0.2 * flock[4], 1e-13);
    EXPECT_NEAR(flock[4] * (1.0 + flock[4] * flock[4]), 0.5 * flock[2] * flock[2], 1e-13);
}

TEST(ModelStates, of_a_flock_with_a_named_direction_are_those_along_it) {
    // (1 - p^2) p = -h: three roots along h, of both signs, and none across.
    for (const double angle : {0.0, 1.234}) {
        const double c = std::cos(angle), s = std::sin(angle);
        const model::Equations equations(
            model::Model{.fields = {spin(1, "p", "(1 - p.p) p + h_x e_x + h_y e_y + lap p")},
                         .coefficients = {{"h_x", 0.1 * c}, {"h_y", 0.1 * s}}});
        const StationaryStates found = stationary_states(equations);
        ASSERT_EQ(found.states.size(), 3u) << testing::PrintToString(names(found));
        for (const StationaryState& state : found.states) {
            const double p = state.values[0] * c + state.values[1] * s;
            EXPECT_NEAR(p - p * p * p + 0.1, 0.0, 1e-14);
            EXPECT_NEAR(state.values[1] * c - state.values[0] * s, 0.0, 1e-14);
            EXPECT_FALSE(state.has_free_direction);
            EXPECT_NEAR(std::abs(std::sin(model::direction_of(equations.model(), state.values) - angle)), 0.0, 1e-13);
        }
    }
}

TEST(ModelStates, of_a_nematic_turn_by_half_of_the_angle_and_its_two_axes_are_one_state) {
    const model::Equations equations(
        model::Model{.fields = {spin(2, "Q", "(0.5 - Q:Q) Q + lap Q"), spin(1, "p", "-p + Q.p + lap p")}});
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 2u);
    EXPECT_NEAR(found.states[1].values[0], 0.5, 1e-14);  // Q:Q = 2 Q_xx^2
    EXPECT_TRUE(found.states[1].has_free_direction);
}

TEST(ModelStates, keep_the_sum_of_densities_that_turn_into_each_other) {
    // k1 u = k2 v with u + v = 3.
    model::Model model{.fields = {scalar("u", "-2 u + v + lap u"), scalar("v", "2 u - v + 3 lap v")}};
    model.fields[0].reference = 1.0, model.fields[1].reference = 2.0;
    const model::Equations equations(model);
    EXPECT_LT((conserved_means(equations).cwiseAbs() - Eigen::RowVector2d(1.0, 1.0) / std::sqrt(2.0)).norm(), 1e-15);
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 1u);
    EXPECT_NEAR(found.states[0].values[0], 1.0, 1e-15);
    EXPECT_NEAR(found.states[0].values[1], 2.0, 1e-15);
    EXPECT_NEAR(growth(model::LinearisedAt(equations, found.states[0].values), 0.0).rate, -3.0,
                1e-14);  // not the sum's 0
}

TEST(ModelStates, are_none_where_rates_are_small_for_large_values_alone) {
    // Rates that tend to 0 or to a number while their terms grow: 10^12 is no root of 1 - s + sqrt(s^2 + 1) > 1.
    for (const char* rate : {"1 - s + sqrt(s^2 + 1)", "1 - s + s^2/(1 + s)", "0.5 - s + sqrt(s^2 + 0.01)"}) {
        const model::Equations equations(model::Model{.fields = {scalar("s", std::string(rate) + " + lap s")}});
        EXPECT_EQ(names(stationary_states(equations)), std::vector<std::string>{}) << rate;
    }
    const model::Equations kink(model::Model{.fields = {scalar("s", "-s + 0.5 + abs(s - 1) + lap s")}});
    const StationaryStates found = stationary_states(kink);
    ASSERT_EQ(found.states.size(), 1u);
    EXPECT_NEAR(found.states[0].values[0], 0.75, 1e-15);
    // Stiff fields, and a root that is far away because a rate is nearly saturated.
    const model::Equations stiff(model::Model{
        .fields = {scalar("a", "1e10 (b - a) + 1 - a^2 + lap a"), scalar("b", "1e10 (a - b) + 2 - b + lap b")}});
    const StationaryStates two = stationary_states(stiff);
    ASSERT_EQ(two.states.size(), 2u);  // 3 - a - a^2 = 0
    for (const auto& [k, root] : {std::pair{0u, -0.5 - std::sqrt(3.25)}, {1u, -0.5 + std::sqrt(3.25)}})
        EXPECT_NEAR(two.states[k].values[0], root, 1e-4);  // rounding of terms of 1e10
    const model::Equations saturated(model::Model{.fields = {scalar("s", "s^2/(1 + s^2) - 1 + 1e-10 + lap s")}});
    ASSERT_EQ(stationary_states(saturated).states.size(), 2u);
    EXPECT_NEAR(stationary_states(saturated).states[1].values[0], 1e5, 1.0);
    // A continuum that ends: its reference is one of it.
    model::Model flat{.fields = {scalar("s", "max(1 - s, 0)^3 - max(s - 2, 0)^3 + lap s")}};
    flat.fields[0].reference = 1.5;
    const StationaryStates of_flat = stationary_states(model::Equations(flat));
    EXPECT_TRUE(std::ranges::any_of(of_flat.states, [](const StationaryState& s) { return s.values[0] == 1.5; }));
    // Roots that coincide are placed by what they are beside each other: to the root, or the cube root, of rounding.
    for (const char* rate : {"-(s - 3)^2", "-(s - 3)^3"}) {
        const model::Equations multiple(model::Model{.fields = {scalar("s", std::string(rate) + " + lap s")}});
        const StationaryStates roots = stationary_states(multiple);
        ASSERT_FALSE(roots.states.empty()) << rate;
        for (const StationaryState& state : roots.states) EXPECT_NEAR(state.values[0], 3.0, 3e-4) << rate;
    }
}

TEST(ModelStates, of_an_epidemic_that_ends_are_one_family) {
    // Any number that was never infected, with none infected: the sum is 1.2.
    model::Model model{.fields = {scalar("S", "-b S I + lap S"), scalar("I", "b S I - g I + lap I"),
                                  scalar("R", "g I + lap R")},
                       .coefficients = {{"b", 0.5}, {"g", 0.2}}};
    model.fields[0].reference = 1.0, model.fields[1].reference = model.fields[2].reference = 0.1;
    const StationaryStates found = stationary_states(model::Equations(model));
    ASSERT_EQ(found.states.size(), 1u) << testing::PrintToString(names(found));
    EXPECT_TRUE(found.states[0].is_of_family);
    EXPECT_EQ(found.why_incomplete, "");
}

TEST(ModelStates, of_functions_with_a_narrow_domain_are_found_in_it) {
    // The gain of order exists for densities within 0.001 of the reference.
    model::Model model{
        .fields = {scalar("n", "lap n"), spin(1, "p", "(1 + sqrt(1e-6 - (n - 1)^2)) p - p.p p + lap p")}};
    model.fields[0].reference = 1.0;
    const model::Equations equations(model);
    EXPECT_TRUE(turns_freely(equations));
    EXPECT_EQ(conserved_means(equations).rows(), 1);
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 2u) << found.why_none;
    EXPECT_NEAR(found.states[1].values[1], std::sqrt(1.001), 1e-14);
    EXPECT_TRUE(found.states[1].has_free_direction);
}

TEST(ModelStates, have_the_conserved_means_that_are_asked_for) {
    // An order that begins above a density of 1.
    model::Model model{.fields = {scalar("n", "-div(n p)"), spin(1, "p", "(n - 1 - p.p) p + lap p - grad n")}};
    model.fields[0].reference = 0.8;
    const model::Equations equations(model);
    EXPECT_EQ(names(stationary_states(equations)), std::vector<std::string>{"isotropic"});
    const StationaryStates found = stationary_states(equations, {1.25, 0.0, 0.0});
    ASSERT_EQ(found.states.size(), 2u);
    EXPECT_EQ(found.states[1].values[0], 1.25);
    EXPECT_NEAR(found.states[1].values[1], 0.5, 1e-15);
}

TEST(ModelStates, of_a_free_phase_are_one_family) {
    const model::Equations equations(model::Model{.fields = {scalar("u", "u - (u^2 + w^2) u + lap u - 0.3 lap w"),
                                                             scalar("w", "w - (u^2 + w^2) w + lap w + 0.3 lap u")}});
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 2u) << testing::PrintToString(names(found));
    const bool first = found.states[0].is_of_family;
    const StationaryState& wave = found.states[first ? 0 : 1];
    EXPECT_TRUE(wave.is_of_family);
    EXPECT_NEAR(std::hypot(wave.values[0], wave.values[1]), 1.0, 1e-14);
}

TEST(ModelStates, of_two_vectors_that_turn_independently_are_four_of_which_one_is_a_family) {
    const StationaryStates found = stationary_states(model::Equations(
        model::Model{.fields = {spin(1, "a", "0.65 a - (a.a) a + lap a"), spin(1, "b", "0.47 b - (b.b) b + lap b")}}));
    ASSERT_EQ(found.states.size(), 4u);
    for (const StationaryState& state : found.states) {
        const double a = std::hypot(state.values[0], state.values[1]), b = std::hypot(state.values[2], state.values[3]);
        EXPECT_NEAR(a, a > 0.1 ? std::sqrt(0.65) : 0.0, 1e-14);
        EXPECT_NEAR(b, b > 0.1 ? std::sqrt(0.47) : 0.0, 1e-14);
        EXPECT_EQ(state.is_of_family, a > 0.1 && b > 0.1);  // their angle is free
    }
    EXPECT_EQ(found.why_incomplete, "");
}

TEST(ModelStates, do_not_exist_with_a_term_that_depends_on_position_or_without_a_root_and_the_reason_is_given) {
    const auto reason = [](const std::string& equation) {
        return stationary_states(model::Equations(model::Model{.fields = {scalar("phi", equation)}})).why_none;
    };
    EXPECT_NE(reason("-phi + 0.3 sin(x) phi + lap phi").find("\"+ 0.3 sin(x) phi\" of phi depends on position or time"),
              std::string::npos);
    EXPECT_NE(reason("1 + phi^2 + lap phi").find("found no uniform stationary state from"), std::string::npos);
}

TEST(ModelStates, have_the_values_of_fields_in_balance_linear_or_at_every_point) {
    model::Model model{.fields = {spin(1, "p", "(1 - p.p) p + lap p + v"), spin(1, "v", "0.5 p - 2 v + lap v"),
                                  spin(1, "w", "p - (1 + p.p) w")}};
    model.fields[1].left = model.fields[2].left = model::LeftSide::balance;
    const StationaryStates found = stationary_states(model::Equations(model));
    ASSERT_EQ(found.states.size(), 2u);
    const model::UniformState& flock = found.states[1].values;
    const double p = std::sqrt(1.25);  // 1 + 1/4 = p^2
    EXPECT_NEAR(flock[0], p, 1e-14);
    EXPECT_NEAR(flock[2], p / 4.0, 1e-14);
    EXPECT_NEAR(flock[4], p / (1.0 + p * p), 1e-14);
    // All components of a wave: v = p/2/(2 + q^2), and w = p (1 + p^2) - 2 p^2 p over (1 + p^2)^2 along x.
    const model::Symbol all = model::LinearisedAt(model::Equations(model), flock).all_components({0.6, 0.0});
    EXPECT_NEAR(all(2, 0).real(), 0.5 / (2.0 + 0.36), 1e-15);
    EXPECT_NEAR(all(4, 0).real(), (1.0 - p * p) / std::pow(1.0 + p * p, 2), 1e-15);
    EXPECT_NEAR(all(5, 1).real(), 1.0 / (1.0 + p * p), 1e-15);
}

TEST(ModelStates, of_a_chiral_order_in_a_field_stand_at_an_angle_to_it) {
    // (1 - P) p + Omega perp p = -h with P = |p|^2: P ((1 - P)^2 + Omega^2) = h^2.
    const double omega = 0.2, h = 0.25;
    const model::Equations equations(
        model::Model{.fields = {spin(1, "p", "(1 - p.p) p + Omega perp p + h e_x + lap p")},
                     .coefficients = {{"Omega", omega}, {"h", h}},
                     .chiral = true});
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 3u) << testing::PrintToString(names(found));
    for (const StationaryState& state : found.states) {
        const Complex p(state.values[0], state.values[1]);
        EXPECT_NEAR(std::norm(p) * (std::pow(1.0 - std::norm(p), 2) + omega * omega), h * h, 1e-14);
        EXPECT_NEAR(std::abs(p + h / Complex(1.0 - std::norm(p), omega)), 0.0, 1e-14);
        EXPECT_FALSE(state.has_free_direction);
    }
}

TEST(ModelStates, in_a_field_are_named_by_it_from_the_largest_along_it_to_the_largest_against_it) {
    // p^3 - p = h has three roots below h = 2/sqrt(27), and a flow that the field drives as well is no order.
    model::Field flow = spin(1, "v", "e_x - 2 v");
    for (const double angle : {0.0, 2.0}) {
        const model::Equations equations(
            model::Model{.fields = {spin(1, "p", "p - p.p p + h (c e_x + s e_y)")},
                         .coefficients = {{"h", 0.2}, {"c", std::cos(angle)}, {"s", std::sin(angle)}}});
        const StationaryStates found = stationary_states(equations);
        EXPECT_EQ(names(found),
                  (std::vector<std::string>{"along the field", "weakly against the field", "against the field"}));
    }
    flow.observed.drawn = 2;
    model::Field order = spin(1, "p", "-p - p.p p");
    order.observed.drawn = 1;
    EXPECT_EQ(names(stationary_states(model::Equations(model::Model{.fields = {flow, order}}))),
              std::vector<std::string>{"isotropic"});
}

}  // namespace
}  // namespace drover::theory::theory_states_tests
