// tests/theory/instabilities.cpp: kinds of growing waves of declared models, their edges, and directions that diffuse.
#include "theory/instabilities.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "theory/models.hpp"

namespace drover::theory::instabilities_tests {
namespace {

std::vector<Instability> grows(const model::LinearisedAt& at) {
    Threads threads(2);
    return growing_waves(at, {}, threads).kinds;
}

model::LinearisedAt at_zero(const model::Model& model) {
    const model::Equations equations(model);
    return {equations, model::UniformState(static_cast<std::size_t>(equations.components()), 0.0)};
}

TEST(ModelInstabilities, of_a_conserved_scalar_separate_phases_up_to_the_neutral_wave) {
    model::Model model{.fields = {scalar("phi", "lap (phi^3 - phi - lap phi)")}};
    model.fields[0].conserved = true;
    const std::vector<Instability> found = grows(at_zero(model));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].kind, InstabilityKind::phase_separation);
    EXPECT_NEAR(found[0].q, std::sqrt(0.5), 1e-7);  // of q^2 - q^4: the square root of rounding, at a maximum
    EXPECT_NEAR(found[0].rate, 0.25, 1e-13);
    EXPECT_NEAR(found[0].max, 1.0, 1e-13);
    EXPECT_EQ(found[0].min, 0.0);
}

TEST(ModelInstabilities, of_a_scalar_that_reacts_are_a_pattern_and_a_change_of_the_whole) {
    const double r = 0.2;
    const std::vector<Instability> pattern =
        grows(at_zero({.fields = {scalar("u", "r u - (u + 2 lap u + lap lap u) - u^3")}, .coefficients = {{"r", r}}}));
    ASSERT_EQ(pattern.size(), 1u);
    EXPECT_EQ(pattern[0].kind, InstabilityKind::pattern);
    EXPECT_NEAR(pattern[0].min, std::sqrt(1.0 - std::sqrt(r)), 1e-13);
    EXPECT_NEAR(pattern[0].max, std::sqrt(1.0 + std::sqrt(r)), 1e-13);
    const std::vector<Instability> whole = grows(at_zero({.fields = {scalar("u", "0.3 u - u^3 + lap u")}}));
    ASSERT_EQ(whole.size(), 1u);
    EXPECT_EQ(whole[0].kind, InstabilityKind::uniform);
    EXPECT_EQ(whole[0].q, 0.0);
    EXPECT_NEAR(whole[0].rate, 0.3, 1e-14);
}

TEST(ModelInstabilities, of_an_ordered_state_as_a_whole_end_with_the_shortest_wave_that_grows_at_any_angle) {
    // At |p| = 1 its size grows by 2 - (1 + k cos^2) q^2 for waves along and across it.
    for (const auto& [k, shortest] : {std::pair{0.0, std::sqrt(2.0)}, {0.7, std::sqrt(2.0)}, {-0.5, 2.0}}) {
        const model::Equations equations(
            {.fields = {spin(1, "p", "-p + p.p p + lap p + k grad div p")}, .coefficients = {{"k", k}}});
        const std::vector<Instability> found = grows(model::LinearisedAt(equations, {1.0, 0.0}));
        const auto whole =
            std::find_if(found.begin(), found.end(), [](const Instability& one) { return one.q == 0.0; });
        ASSERT_NE(whole, found.end());
        EXPECT_NEAR(whole->rate, 2.0, 1e-13);
        EXPECT_EQ(whole->min, 0.0);
        EXPECT_NEAR(whole->max, shortest, 1e-12);  // a root by bisection, at a maximum over angles
    }
}

TEST(ModelInstabilities, of_an_isotropic_state_are_listed_for_every_range_of_waves) {
    // 0.1 - (1 - q^2)^2 for u, 0.3 - (9 - q^2)^2 for v: two ranges that do not meet.
    const std::vector<Instability> found =
        grows(at_zero({.fields = {scalar("u", "0.1 u - (u + 2 lap u + lap lap u)"),
                                  scalar("v", "0.3 v - (81 v + 18 lap v + lap lap v)")}}));
    ASSERT_EQ(found.size(), 2u);
    EXPECT_NEAR(found[0].rate, 0.3, 1e-12);
    EXPECT_NEAR(found[0].q, 3.0, 1e-6);
    EXPECT_NEAR(found[1].rate, 0.1, 1e-12);
    EXPECT_NEAR(found[1].q, 1.0, 1e-6);
}

TEST(ModelInstabilities, of_a_nematic_at_rest_are_order) {
    const std::vector<Instability> found = grows(at_zero({.fields = {spin(2, "Q", "0.4 Q - (Q:Q) Q + lap Q")}}));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].kind, InstabilityKind::order);
    EXPECT_NEAR(found[0].max, std::sqrt(0.4), 1e-12);
}

TEST(ModelInstabilities, of_flocks_are_looked_for_on_both_sides_of_the_order_where_left_and_right_differ) {
    // The odd term k perp grad c turns waves to one side; without it the flock is its own mirror image.
    for (const double k : {0.0, 0.7, -0.7}) {
        model::Model model{.fields = {scalar("c", "-div(c p) + lap c"),
                                      spin(1, "p", "p - p.p p + lap p + 3 grad c + k perp grad c")},
                           .coefficients = {{"k", k}},
                           .chiral = true};
        model.fields[0].conserved = true;
        model.fields[0].reference = 1.0;
        const model::LinearisedAt flock = about(model, 1);
        EXPECT_EQ(flock.is_mirrored(), k == 0.0);
        EXPECT_FALSE(flock.is_isotropic());
        const std::vector<Instability> found = grows(flock);
        ASSERT_FALSE(found.empty());
        // By brute force over half a turn, in steps of one degree and 1 % of q: second order in the steps.
        double most = 0.0;
        for (int a = 0; a < 180; ++a)
            for (int n = 0; n < 600; ++n)
                most = std::max(most, growth_rate(flock, 0.01 * std::pow(1.01, n), a * pi / 180.0));
        EXPECT_NEAR(found[0].rate, most, 1e-3 * most);
        EXPECT_GE(found[0].rate, most);
    }
}

TEST(ModelInstabilities, turn_the_direction_of_a_flock_and_of_a_nematic_by_their_noise) {
    // <f f> = D delta delta: f across the mean order P turns it by the angle f/(m P), since F turns by m theta.
    const double noise = 0.3;
    for (const int m : {1, 2}) {
        model::Model model{
            .fields = {m == 1 ? spin(1, "p", "0.5 p - 2 p.p p + lap p") : spin(2, "p", "0.5 p - 2 (p:p) p + lap p")}};
        model.fields[0].noise = noise;
        const model::Equations equations(model);
        const StationaryStates found = stationary_states(equations);
        const model::UniformState& state = found.states.at(1).values;
        ASSERT_TRUE(found.states[1].has_free_direction);
        const model::LinearisedAt at(equations, state);
        const double size = std::hypot(state[0], state[1]);
        EXPECT_NEAR(direction_diffusion(at, long_waves(at)), 0.5 * noise / std::pow(m * size, 2), 1e-13);
    }
}

TEST(ModelStates, nearest_to_samples_go_by_the_size_of_the_order_or_where_it_is_held_by_its_direction) {
    const model::Model model{.fields = {spin(1, "p", "-p")}};
    const auto state = [](double x, bool is_free) {
        return StationaryState{.name = "", .values = {x, 0.0}, .is_isotropic = x == 0.0, .has_free_direction = is_free};
    };
    const std::vector<model::UniformState> samples{{0.0, 0.9}, {-0.9, 0.0}};  // of size 0.9, with a mean of 0.6
    const StationaryStates free{.states = {state(0.0, false), state(1.0, true)}, .why_none = "", .why_no_order = ""};
    EXPECT_EQ(nearest_state(free, model, samples), &free.states[1]);
    const StationaryStates held{.states = {state(1.0, false), state(-0.8, false)}, .why_none = "", .why_no_order = ""};
    EXPECT_EQ(nearest_state(held, model, samples), &held.states[1]);
    EXPECT_EQ(nearest_state({}, model, samples), nullptr);
}

}  // namespace
}  // namespace drover::theory::instabilities_tests
