// tests/theory/rod_bead.cpp: the linear theory of the rod-bead equations with masses and balances, beside that of
// their right sides alone and closed forms.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "drover/theory/theory.hpp"
#include "physics/flock_model.hpp"
#include "physics/full_model.hpp"
#include "physics/linear_modes.hpp"
#include "physics/modes.hpp"
#include "physics/structure.hpp"
#include "theory/models.hpp"

namespace drover::theory::theory_rod_bead_tests {
namespace {

/// A flock with random coefficients and noise on every density and on the order.
physics::Model random_flock(std::mt19937& random, bool slaved) {
    std::uniform_real_distribution<double> factor(0.7, 1.3);
    physics::Letters l;
    for (double* value : {&l.rho, &l.gamma, &l.eta, &l.zeta, &l.alpha, &l.e, &l.f, &l.b, &l.k3, &l.k1, &l.lambda, &l.w,
                          &l.pressure_a, &l.pressure_b})
        *value *= factor(random);
    l.a = 0.5 * l.lambda * l.alpha / l.gamma;  // a flock
    physics::Model model = physics::flock_model(l);
    if (slaved) model.fields.bead_velocity = "slaved";
    model.noise = {.order = 0.3, .rods = 0.12, .beads = 0.07};
    model.diffusion = {.beads = 0.05 * factor(random), .rods = 0.04 * factor(random)};
    return model;
}

model::Equations equations_of(const physics::Model& model) {
    return physics::Equations(model).solver(physics::mean_densities(model));
}

/// Of a wave: rounding times the ratio of the fastest rate to the slowest, and the condition of the modes.
constexpr double tolerance = 1e-12;

TEST(ModelTheory, of_the_rod_bead_equations_has_the_states_of_the_closed_form) {
    std::mt19937 random(3);
    for (const bool slaved : {false, true}) {
        const physics::Model built_in = random_flock(random, slaved);
        const physics::Equations equations(built_in);
        const StationaryStates found = stationary_states(equations_of(built_in));
        ASSERT_EQ(names(found), (std::vector<std::string>{"isotropic", "ordered"}));
        const physics::UniformPoint flock = physics::flock(equations, 0.0);
        const auto at_point = ordered_state(equations.theory(), equations.right_sides().reference());
        ASSERT_TRUE(at_point);
        const std::vector<double> values = physics::values_of(equations, flock);
        for (std::size_t i = 0; i < values.size(); ++i) {
            EXPECT_NEAR(found.states[1].values[i], values[i], 1e-14) << i;
            EXPECT_NEAR(at_point->values[i], values[i], 1e-14) << i;
        }
        EXPECT_TRUE(found.states[1].has_free_direction);
    }
}

TEST(ModelTheory, of_the_rod_bead_equations_has_the_states_of_a_search_without_one) {
    std::mt19937 random(17);
    std::vector<physics::Model> models;
    for (const physics::NamedModel& form : physics::all_forms()) models.push_back(form.model);
    for (const bool slaved : {false, true}) models.push_back(random_flock(random, slaved));
    int ordered = 0;
    for (physics::Model& model : models) {
        model.force.kind = "none";
        model.orienting_field = {};
        for (const double rate : {model.relaxation.rate, model.relaxation.rate - 6.0}) {
            model.relaxation.rate = rate;
            const physics::Equations built_in(model);
            const StationaryStates searched = stationary_states(built_in.solver());
            const auto found = states_of_cubic_order(built_in.theory(), built_in.solver().reference());
            ASSERT_TRUE(found);
            ASSERT_EQ(names(*found), names(searched));
            EXPECT_EQ(found->why_no_order.empty(), searched.why_no_order.empty());
            for (std::size_t n = 0; n < found->states.size(); ++n) {
                EXPECT_EQ(found->states[n].has_free_direction, searched.states[n].has_free_direction);
                for (std::size_t k = 0; k < found->states[n].values.size(); ++k)
                    EXPECT_NEAR(found->states[n].values[k], searched.states[n].values[k], 1e-12) << n << ", " << k;
            }
            ordered += static_cast<int>(found->states.size()) - 1;
        }
    }
    EXPECT_GT(ordered, 5);
    models.front().orienting_field = {.x = 0.1};  // more states than two
    const physics::Equations pushed(models.front());
    EXPECT_FALSE(states_of_cubic_order(pushed.theory(), pushed.solver().reference()));
}

TEST(ModelTheory, of_the_rod_bead_equations_has_their_growth_and_long_waves_at_random_coefficients) {
    std::mt19937 random(5);
    for (int trial = 0; trial < 6; ++trial) {
        const physics::Equations built_in(random_flock(random, false));
        const model::Equations equations = built_in.solver();
        const physics::StationaryState flock = physics::flock_of(built_in);
        const model::LinearisedAt at(equations,
                                     {flock.point.bead_density, flock.point.rod_density, flock.point.velocity.x(),
                                      flock.point.velocity.y(), flock.point.order.x(), flock.point.order.y()});
        for (const double q : {0.05, 0.6, 3.0})
            for (const double angle : {0.0, 0.8, pi / 2.0, 2.3}) {
                const Growth found = growth(at, q, angle);
                const physics::Growth expected = physics::growth(built_in, flock.point, q, angle);
                EXPECT_NEAR(found.rate, expected.rate, tolerance) << q << ", " << angle;
                EXPECT_NEAR(found.frequency, expected.frequency, tolerance);
            }
        const physics::LongWaves waves = physics::long_waves(built_in, flock);
        for (const double angle : {0.4, 1.3, 2.0}) {
            const SlowModes found = slow_modes(at, angle);
            const std::vector<physics::SlowMode> expected = physics::slow_modes(waves, angle);
            ASSERT_EQ(found.modes.size(), expected.size());
            for (std::size_t k = 0; k < expected.size(); ++k) {
                EXPECT_LT(std::abs(found.modes[k].speed - expected[k].speed), tolerance);
                EXPECT_LT(std::abs(found.modes[k].damping - expected[k].damping), 10.0 * tolerance);
            }
            EXPECT_LT(damping_error(at, angle, found.modes), 1e-3);
        }
    }
}

TEST(ModelTheory, of_the_rod_bead_equations_has_their_structure_factors_with_beads_in_balance_as_well) {
    std::mt19937 random(8);
    for (const bool slaved : {false, true}) {
        const physics::Equations built_in(random_flock(random, slaved));
        const model::Equations equations = built_in.solver();
        const physics::StationaryState flock = physics::flock_of(built_in);
        const model::LinearisedAt at(equations,
                                     {flock.point.bead_density, flock.point.rod_density, flock.point.velocity.x(),
                                      flock.point.velocity.y(), flock.point.order.x(), flock.point.order.y()});
        for (const double q : {0.2, 2.0})
            for (const double angle : {0.3, 1.2}) {
                const numerics::Wavevector k = at.wavevector(q, angle);
                const physics::Symbol expected = physics::structure_matrix(built_in, flock.point, k),
                                      spectrum = physics::dynamic_structure_matrix(built_in, flock.point, k, 0.4);
                const Covariance found = covariance(at, k);
                ASSERT_EQ(found.why_none, "");
                const model::Symbol found_spectrum = dynamic_structure(at, k, 0.4);
                for (const int i : equations.state_components())
                    for (const int j : equations.state_components()) {
                        EXPECT_LT(std::abs(found.matrix(i, j) - expected(i, j)), tolerance * expected.norm());
                        EXPECT_LT(std::abs(found_spectrum(i, j) - spectrum(i, j)), tolerance * spectrum.norm());
                    }
            }
    }
}

TEST(ModelTheory, of_the_rod_bead_equations_finds_their_fastest_wave) {
    // Densities that attract: an instability of oblique waves.
    std::mt19937 random(9);
    physics::Model attracting = random_flock(random, false);
    attracting.pressure = {.beads = -0.9, .rods = 0.2};
    const physics::Equations built_in(attracting);
    const physics::StationaryState flock = physics::flock_of(built_in);
    const std::vector<Instability> expected = physics::instabilities(built_in, flock, {.min = 1e-2, .max = 10});
    ASSERT_FALSE(expected.empty());
    const model::Equations equations = equations_of(attracting);
    const model::LinearisedAt at(equations, stationary_states(equations).states.at(1).values);
    Threads threads(2);
    const FastestWave found =
        growing_waves(at, {.min = 1e-2, .max = 10, .wavenumbers = 60, .angles = 40}, threads).fastest;
    EXPECT_NEAR(found.growth.rate, expected[0].rate, 1e-12);
    EXPECT_NEAR(found.q, expected[0].q, 1e-5);  // the square root of rounding, at a maximum
    std::complex<double> sum = 0.0;
    for (const std::complex<double> share : found.shares) sum += share;
    EXPECT_NEAR(sum.real(), found.growth.rate, 1e-13);
}

}  // namespace
}  // namespace drover::theory::theory_rod_bead_tests
