// tests/physics/stability.cpp: modes of waves on uniform states against closed forms; what grows, found and named.

#include <gtest/gtest.h>

#include <numbers>

#include "drover/base/random.hpp"
#include "flock_model.hpp"
#include "linear_modes.hpp"
#include "physics/rod_bead_model.hpp"
#include "symbols.hpp"

namespace drover::physics::stability_tests {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

// ---- the matrices of the closed forms

/// The ordered state, p0 along x, m = u = 1, J = u p; slopes of coefficients with the densities in columns n.
Symbol flock_matrix(const Letters& l, double a_n[2], double lambda_n[2], double b_n[2], double alpha_n[2],
                    double gamma_n[2], const numerics::Wavevector& q) {
    const Complex i(0.0, 1.0);
    const double square = q.x * q.x + q.y * q.y, p0 = l.p0(), v0 = l.v0(), gain = l.lambda * l.alpha / l.gamma;
    Symbol m = Symbol::Zero();
    m.row(FieldIndex::bead_density) << -i * v0 * q.x, 0, -i * l.rho * q.x, -i * l.rho * q.y, 0, 0;
    m.row(FieldIndex::rod_density) << 0, 0, 0, 0, -i * q.x, -i * q.y;
    m.row(FieldIndex::bead_velocity_x) << -i * l.e * q.x / l.rho, -i * l.f * q.x / l.rho,
        -(l.gamma + l.eta * square + l.zeta * q.x * q.x) / l.rho, -l.zeta * q.x * q.y / l.rho, l.alpha / l.rho, 0;
    m.row(FieldIndex::bead_velocity_y) << -i * l.e * q.y / l.rho, -i * l.f * q.y / l.rho, -l.zeta * q.x * q.y / l.rho,
        -(l.gamma + l.eta * square + l.zeta * q.y * q.y) / l.rho, 0, l.alpha / l.rho;
    m.row(FieldIndex::polar_order_x) << -i * l.pressure_a * q.x, -i * l.pressure_b * q.x, l.lambda, 0,
        -gain - 2.0 * l.b * p0 * p0 - i * l.w * p0 * q.x - l.k3 * square - l.k1 * q.x * q.x, -l.k1 * q.x * q.y;
    m.row(FieldIndex::polar_order_y) << -i * l.pressure_a * q.y, -i * l.pressure_b * q.y, 0, l.lambda,
        -l.k1 * q.x * q.y, -gain - i * l.w * p0 * q.x - l.k3 * square - l.k1 * q.y * q.y;
    for (int n = 0; n < 2; ++n) {
        m(FieldIndex::polar_order_x, n) += -a_n[n] * p0 + lambda_n[n] * v0 - b_n[n] * p0 * p0 * p0;
        m(FieldIndex::bead_velocity_x, n) += (alpha_n[n] * p0 - gamma_n[n] * v0) / l.rho;
    }
    return m;
}

TEST(LinearSymbol, of_a_flock_is_the_matrix_of_the_closed_form) {
    const Letters l;
    double none[2]{};
    const Equations plain(flock_model(l));
    // Slopes about the densities that keep the values: c = c0 + slope (n - n0).
    double a_n[2]{-0.11, -0.23}, lambda_n[2]{0.31, 0.17}, b_n[2]{0.07, -0.05}, alpha_n[2]{0.13, 0.19},
        gamma_n[2]{-0.29, 0.37};
    Model model = flock_model(l);
    const double sigma = model.uniform.rod_density;
    const auto slope = [&](double& value, std::vector<std::string>& terms, const double by[2]) {
        value -= by[0] * l.rho + by[1] * sigma;
        terms = {text("{} rho", by[0]), text("{} sigma", by[1])};
    };
    slope(model.relaxation.rate, model.relaxation.rate_terms, a_n);
    slope(model.weathercock.strength, model.weathercock.strength_terms, lambda_n);
    slope(model.relaxation.saturation, model.relaxation.saturation_terms, b_n);
    slope(model.driving.strength, model.driving.strength_terms, alpha_n);
    slope(model.drag.coefficient, model.drag.coefficient_terms, gamma_n);
    const Equations varying(model);
    std::vector<double> numbers(40);
    fill_normal({.seed = 3, .stream = Stream::test}, 0, 1, numbers);
    for (std::size_t k = 0; k < 40; k += 2) {
        const numerics::Wavevector q{numbers[k], numbers[k + 1]};
        const Symbol exact = flock_matrix(l, none, none, none, none, none, q);
        EXPECT_LT((linear_symbol(plain, flock_of(plain).point, q) - exact).cwiseAbs().maxCoeff(), 1e-12);
        const Symbol with_slopes = flock_matrix(l, a_n, lambda_n, b_n, alpha_n, gamma_n, q);
        EXPECT_LT((linear_symbol(varying, flock_of(varying).point, q) - with_slopes).cwiseAbs().maxCoeff(), 1e-12);
    }
}

TEST(ModeRates, of_the_isotropic_state_across_q_solve_the_quadratic) {
    for (const double a : {0.5, 1.4}) {
        const Letters l{.a = a};
        const Equations e(flock_model(l));
        for (const double q : {0.0, 0.3, 2.0}) {
            const Eigen::VectorXcd rates = mode_rates(e, isotropic_of(e).point, {.x = q, .y = 0.0});
            // (rho s + Gamma + eta q^2)(s + a + K3 q^2) = lambda alpha
            const double g = (l.gamma + l.eta * q * q) / l.rho, h = l.a + l.k3 * q * q, k = l.lambda * l.alpha / l.rho;
            for (const double sign : {-1.0, 1.0}) {
                const double s = 0.5 * (-(g + h) + sign * std::sqrt((g - h) * (g - h) + 4.0 * k));
                EXPECT_LT((rates.array() - s).abs().minCoeff(), 1e-12) << q;
            }
        }
    }
}

TEST(NeutralWavenumber, of_the_order_across_q_is_the_closed_form_with_and_without_viscosity) {
    for (const double eta : {0.0, 0.7}) {
        const Letters l{.eta = eta};
        const Equations e(flock_model(l));
        const double expected =
            std::sqrt(-2.0 * l.gamma * l.abar() /
                      (l.gamma * l.k3 + eta * l.a +
                       std::sqrt(std::pow(l.gamma * l.k3 + eta * l.a, 2) - 4.0 * eta * l.k3 * l.gamma * l.abar())));
        EXPECT_NEAR(effective_coefficients(e, l.rho, 0.9).neutral_wavenumber, expected, 1e-14);
        EXPECT_NEAR((l.gamma + eta * expected * expected) * (l.a + l.k3 * expected * expected), l.lambda * l.alpha,
                    1e-13);
        const Growth at = growth(e, isotropic_of(e).point, expected, 0.0),
                     beyond = growth(e, isotropic_of(e).point, 1.01 * expected, 0.0);
        EXPECT_NEAR(at.rate, 0.0, 1e-13);
        EXPECT_LT(beyond.rate, 0.0);
    }
}

TEST(Growth, of_order_just_past_the_threshold_is_minus_abar_over_chi) {
    // -abar/chi + O(abar^2): the error falls by four when abar is halved.
    double last = 0.0;
    for (const double abar : {-0.02, -0.01, -0.005}) {
        Letters l;
        l.a = l.lambda * l.alpha / l.gamma + abar;
        const Equations e(flock_model(l));
        const double wrong = std::abs(growth(e, isotropic_of(e).point, 0.0, 0.0).rate + abar / l.chi());
        if (last > 0.0) {
            EXPECT_NEAR(last / wrong, 4.0, 0.1);
        }
        last = wrong;
    }
}

TEST(ModeRates, of_a_model_with_a_point_force_have_no_mode_of_the_force) {
    Model model = flock_model(isotropic_letters());
    const Equations without(model);
    model.force = {.kind = "point", .x = 0.3};
    const Equations with(model);
    const UniformPoint rest = isotropic_of(without).point;
    for (const numerics::Wavevector& q : {numerics::Wavevector{0.3, 0.0}, {0.5, -0.7}})
        EXPECT_EQ(mode_rates(with, rest, q), mode_rates(without, rest, q));                         // the same sums
    EXPECT_EQ(slow_modes(long_waves(with, {.name = "isotropic", .point = rest}), 0.0).size(), 2u);  // two densities
}

// ---- branches

std::vector<double> steps(double first, double last, int count) {
    std::vector<double> result;
    for (int k = 0; k < count; ++k) result.push_back(first + (last - first) * k / (count - 1));
    return result;
}

TEST(ModeMap, holds_eigenvectors_with_their_duals) {
    const Equations e(flock_model({}));
    const auto at = linearised(e, flock_of(e).point);
    Threads threads(2);
    const theory::ModeMap map = theory::mode_map(*at, steps(0.05, 2.0, 20), steps(0.0, pi, 13), threads);
    for (std::size_t a = 0; a < map.angles.size(); ++a)
        for (std::size_t k = 0; k < map.wavenumbers.size(); ++k) {
            const Modes& here = map.at(a, k);
            const model::Symbol m = at->symbol(at->wavevector(map.wavenumbers[k], map.angles[a]));
            const model::Symbol left = here.shapes * here.rates.asDiagonal() * here.duals;
            EXPECT_LT((left - m).cwiseAbs().maxCoeff(), 1e-11) << a << ", " << k;  // condition of the shapes: some 100
        }
}

TEST(ModeMap, follows_branches_through_crossings) {
    // Isotropic: waves along q and across it do not know of each other, and their rates cross: across by order alone,
    // along by the pressure too.  Rates on one branch are smooth: second differences of order (step)^2.
    Letters l = isotropic_letters();
    const Equations e(flock_model(l));
    Threads threads(1);
    const std::vector<double> q = steps(0.01, 3.0, 300);
    const theory::ModeMap map = theory::mode_map(*linearised(e, isotropic_of(e).point), q, {0.4}, threads);
    for (Eigen::Index branch = 0; branch < 6; ++branch)
        for (std::size_t k = 1; k + 1 < q.size(); ++k) {
            // Across or along, for ever.
            const auto across = [&](std::size_t at) {
                const auto& shape = map.at(0, at).shapes.col(branch);
                return std::abs(shape(4) * std::cos(0.4) + shape(5) * std::sin(0.4)) + std::abs(shape(0)) +
                           std::abs(shape(1)) <
                       1e-6;
            };
            EXPECT_EQ(across(k), across(0)) << "branch " << branch << " at " << q[k];
        }
}

TEST(ModeMap, of_a_defective_matrix_keeps_every_rate) {
    // Beads alone, damped sound: rho s^2 + Gamma s + rho E q^2 = 0 has a double root without a second vector at q =
    // Gamma/(2 rho sqrt E).
    const Letters l{.alpha = 0.0, .f = 0.0, .lambda = 0.0};
    Model model = flock_model(l);
    model.viscosity = {};
    const Equations e(model);
    const double q = l.gamma / (2.0 * l.rho * std::sqrt(l.e));
    Threads threads(1);
    const theory::ModeMap map =
        theory::mode_map(*linearised(e, isotropic_of(e).point), {0.5 * q, q, 1.5 * q}, {0.0}, threads);
    for (std::size_t k = 0; k < 3; ++k) {
        Eigen::VectorXcd expected = mode_rates(e, isotropic_of(e).point, {.x = map.wavenumbers[k], .y = 0.0});
        for (const Complex rate : map.at(0, k).rates)
            EXPECT_LT((expected.array() - rate).abs().minCoeff(), 1e-7);  // root of rounding
        const Complex sum = map.at(0, k).rates.sum();
        EXPECT_NEAR(std::abs(sum - expected.sum()), 0.0, 1e-12);
    }
    const double s = -l.gamma / (2.0 * l.rho);
    EXPECT_EQ(((map.at(0, 1).rates.array() - s).abs() < 1e-6).count(), 2);
}

// ---- what grows

const theory::GrowthSearch search{.min = 1e-3, .max = 50.0};

using theory::Instability;
using theory::InstabilityKind;

std::vector<std::string> names(const std::vector<Instability>& found) {
    std::vector<std::string> result;
    for (const Instability& one : found) result.push_back(name_of(one.kind));
    return result;
}

TEST(Instabilities, of_a_stable_state_are_empty) {
    const Equations isotropic(flock_model(isotropic_letters())), flock(flock_model({}));
    EXPECT_TRUE(instabilities(isotropic, isotropic_of(isotropic), search).empty());
    EXPECT_TRUE(instabilities(flock, flock_of(flock), search).empty());
}

TEST(Instabilities, of_the_isotropic_state_past_its_threshold_is_order) {
    const Equations e(flock_model({}));
    const std::vector<Instability> found = instabilities(e, isotropic_of(e), search);
    ASSERT_EQ(names(found), std::vector<std::string>{"order"});
    EXPECT_NEAR(found[0].max, effective_coefficients(e, 1.3, 0.9).neutral_wavenumber, 1e-9);
    EXPECT_EQ(found[0].min, 0.0);
}

TEST(Instabilities, of_densities_that_attract_is_phase_separation) {
    Letters l = isotropic_letters();
    l.f = 3.0;
    l.pressure_a = 1.5;  // E B < F A
    ASSERT_LT(l.e * l.bbar(), l.f * l.abar_beads());
    const Equations e(flock_model(l));
    EXPECT_EQ(names(instabilities(e, isotropic_of(e), search)), std::vector<std::string>{"phase separation"});
}

/// Rods alone that order more where they are dense, past their threshold: the flock breaks into bands.
const Model banding_rods{.uniform = {.rod_density = 1.1},
                         .current = {.speed = 1.0},
                         .relaxation = {.rate = 1.0, .rate_terms = {"-1 sigma"}, .saturation = 1.0},
                         .elasticity = {.stiffness = 1.0},
                         .advection = {.strength = 1.0},
                         .pressure = {.rods = 1.0}};

TEST(Instabilities, of_a_flock_that_order_feeds_are_banding) {
    const Equations e(banding_rods);
    const std::vector<Instability> found = instabilities(e, flock_of(e), search);
    ASSERT_FALSE(found.empty());
    EXPECT_NE(std::find_if(found.begin(), found.end(),
                           [](const Instability& i) { return i.kind == InstabilityKind::banding && i.angle == 0.0; }),
              found.end());
}

TEST(InstabilitiesLong, of_a_flock_with_attracting_beads_are_oblique_and_the_fastest_is_found) {
    const Letters l{.e = 0.2, .w = 0.6, .pressure_a = -0.9};
    ASSERT_LT(l.abar_beads(), 0.0);
    const Equations e(flock_model(l));
    const StationaryState flock = flock_of(e);
    const std::vector<Instability> found = instabilities(e, flock, search);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].kind, InstabilityKind::oblique);
    // By brute force, over steps of 0.5 degrees and 1 % in q: not more than the refined maximum, and not less than
    // second order in the steps.
    double most = 0.0;
    for (int k = 0; k < 700; ++k)
        for (int a = 0; a <= 180; ++a)
            most = std::max(most, growth(e, flock.point, 0.01 * std::pow(1.01, k), a * pi / 360.0).rate);
    EXPECT_LE(most, found[0].rate * (1.0 + 1e-12));
    EXPECT_NEAR(most, found[0].rate, 1e-3 * found[0].rate);
}

TEST(Instabilities, without_a_short_wave_cutoff_are_flagged) {
    Letters l{.k3 = 0.0, .k1 = 0.0};
    l.pressure_a = -3.0;
    const Equations e(flock_model(l));
    const std::vector<Instability> found = instabilities(e, flock_of(e), search);
    ASSERT_FALSE(found.empty());
    EXPECT_TRUE(found[0].at_shortest);
    EXPECT_TRUE(std::isinf(found[0].max));
}

TEST(Instabilities, in_a_field_are_searched_all_round) {
    Letters l{.e = 0.2, .w = 0.6, .pressure_a = -0.9};
    Model model = flock_model(l);
    const Equations free(model);
    model.orienting_field = {.x = 1e-9, .y = 0.0};  // too weak to change a rate by more than itself
    const Equations held(model);
    const double expected = instabilities(free, flock_of(free), search).at(0).rate;
    EXPECT_NEAR(instabilities(held, stationary_states(held).states.at(0), search).at(0).rate, expected, 1e-6);
}

TEST(Instabilities, in_a_field_keep_their_names_and_are_listed_once) {
    Model held = banding_rods;
    held.orienting_field = {.x = 3e-7, .y = 4e-7};
    const Equations free(banding_rods), with(held);
    EXPECT_EQ(names(instabilities(with, stationary_states(with).states.at(0), search)),
              names(instabilities(free, flock_of(free), search)));
    // Against the field it turns as a whole at h/p, and the faster waves keep their names.
    const std::vector<std::string> against = names(instabilities(with, stationary_states(with).states.back(), search));
    EXPECT_EQ(against.front(), "oblique");
    EXPECT_EQ(std::count(against.begin(), against.end(), "uniform"), 1);
}

TEST(Instabilities, of_attracting_rods_past_the_threshold_are_both_reported) {
    const Equations e(Model{.uniform = {.rod_density = 1.0},
                            .current = {.speed = 1.0},
                            .relaxation = {.rate = -0.001, .saturation = 1.0},
                            .elasticity = {.stiffness = 0.5},
                            .pressure = {.rods = -5.0}});
    EXPECT_EQ(names(instabilities(e, isotropic_of(e), search)),
              (std::vector<std::string>{"phase separation", "order"}));
}

TEST(Instabilities, exclude_rounding_errors_for_stiff_beads_and_defective_modes) {
    Letters free{.gamma = 0.0, .alpha = 0.0, .f = 0.0, .a = -1.0, .w = 0.0, .pressure_a = 0.0};
    Model model = flock_model(free);
    const Equations defective(model);
    for (const Instability& one : instabilities(defective, stationary_states(defective).states.back(), search))
        EXPECT_GT(one.rate, 1e-6) << name_of(one.kind);
    Model stiff = flock_model({});
    stiff.inertia.bead_mass = 1e-13;
    const Equations light(stiff);
    const std::vector<Instability> found = instabilities(light, isotropic_of(light), search);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].kind, InstabilityKind::order);
}

TEST(Instabilities, of_a_flock_against_its_field_is_uniform_rotation) {
    Model model = flock_model({});
    model.orienting_field = {.x = 0.01, .y = 0.0};
    const Equations e(model);
    const StationaryStates found = stationary_states(e);
    ASSERT_EQ(found.states.size(), 3u);
    EXPECT_TRUE(instabilities(e, found.states[0], search).empty());
    EXPECT_EQ(instabilities(e, found.states[2], search).at(0).kind, InstabilityKind::uniform);
}

}  // namespace
}  // namespace drover::physics::stability_tests
