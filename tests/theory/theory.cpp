// tests/theory/theory.cpp: growth, fluctuations and long waves of declared models beside exact results.
#include "theory/instabilities.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "theory/models.hpp"

namespace drover::theory::theory_tests {
namespace {

model::Model swift_hohenberg(double r) {
    return {.fields = {scalar("u", "r u - (q0^4 u + 2 q0^2 lap u + lap lap u) - u^3")},
            .coefficients = {{"r", r}, {"q0", 1.3}}};
}

// ---- growth

TEST(ModelGrowth, of_swift_hohenberg_is_its_polynomial_with_its_maximum_and_its_edges) {
    const double r = 0.21, q0 = 1.3;
    const model::LinearisedAt rest = about(swift_hohenberg(r), 0);
    EXPECT_EQ(rest.about()[0], 0.0);
    for (const double q : {0.0, 0.4, 1.3, 2.5}) {
        const Growth found = growth(rest, q, 1.1);
        EXPECT_NEAR(found.rate, r - std::pow(q0 * q0 - q * q, 2), 1e-13 * std::pow(q0 + q, 4));
        EXPECT_EQ(found.frequency, 0.0);
    }
    Threads threads(2);
    const FastestWave fastest = growing_waves(rest, {}, threads).fastest;
    EXPECT_NEAR(fastest.growth.rate, r, 1e-13);
    EXPECT_NEAR(fastest.q, q0, 1e-7);  // the square root of rounding, at a maximum
    EXPECT_FALSE(fastest.at_min || fastest.at_max);
    const std::vector<Band> bands = growth_bands(rest, 0.0, {});
    ASSERT_EQ(bands.size(), 1u);
    EXPECT_NEAR(bands[0].min, std::sqrt(q0 * q0 - std::sqrt(r)), 1e-13);
    EXPECT_NEAR(bands[0].max, std::sqrt(q0 * q0 + std::sqrt(r)), 1e-13);
    EXPECT_FALSE(bands[0].reaches_min || bands[0].reaches_max);
}

TEST(ModelGrowth, in_a_band_between_two_wavenumbers_of_the_search_is_found) {
    const model::LinearisedAt rest =
        about(swift_hohenberg(1e-6));  // a width of 4e-4 of q; the search has steps of 10 %
    EXPECT_EQ(growth_bands(rest, 0.0, {}).size(), 1u);
    EXPECT_TRUE(growth_bands(about(swift_hohenberg(-1e-6)), 0.0, {}).empty());
}

TEST(ModelGrowth, of_a_turing_pattern_has_the_edges_of_the_quadratic_formula) {
    // Brusselator: u = A, v = B/A; det = D_u D_v Q^2 + (A^2 D_u - (B - 1) D_v) Q + A^2 with Q = q^2.
    const double a = 1.5, b = 2.4, du = 0.3, dv = 4.0;
    model::Model model{.fields = {scalar("u", "A - (B + 1) u + u^2 v + Du lap u"),
                                  scalar("v", "B u - u^2 v + Dv lap v")},
                       .coefficients = {{"A", a}, {"B", b}, {"Du", du}, {"Dv", dv}}};
    const model::LinearisedAt state = about(model);
    EXPECT_NEAR(state.about()[0], a, 1e-14);
    EXPECT_NEAR(state.about()[1], b / a, 1e-14);
    const double half = (a * a * du - (b - 1.0) * dv) / 2.0, root = std::sqrt(half * half - du * dv * a * a);
    const std::vector<Band> bands = growth_bands(state, 0.0, {});
    ASSERT_EQ(bands.size(), 1u);
    EXPECT_NEAR(bands[0].min, std::sqrt((-half - root) / (du * dv)), 1e-13);
    EXPECT_NEAR(bands[0].max, std::sqrt((-half + root) / (du * dv)), 1e-13);
    EXPECT_EQ(bands[0].growth.frequency, 0.0);
    // Beyond B = 1 + A^2 the uniform state oscillates with A: a Hopf bifurcation.
    model.coefficients["B"] = 1.0 + a * a, model.coefficients["Dv"] = du;
    const Growth uniform = growth(about(model), 0.0);
    EXPECT_NEAR(uniform.rate, 0.0, 1e-13);
    EXPECT_NEAR(uniform.frequency, a, 1e-13);
}

TEST(ModelGrowth,
     of_plane_waves_of_the_ginzburg_landau_equation_changes_sign_at_the_criterion_of_benjamin_feir_newell) {
    // In the frame of the uniform oscillation: growth of the phase -(1 + alpha beta) q^2 + O(q^4).
    for (const auto& [alpha, beta] : {std::pair{2.0, -0.45}, {2.0, -0.55}, {-1.1, 0.8}, {-1.1, 1.0}, {0.7, 0.6}}) {
        const model::Model model{.fields = {scalar("u", "u + lap u - alpha lap w - (u^2 + w^2)(u - beta w) - beta w"),
                                            scalar("w", "w + lap w + alpha lap u - (u^2 + w^2)(w + beta u) + beta u")},
                                 .coefficients = {{"alpha", alpha}, {"beta", beta}}};
        const model::LinearisedAt wave(model::Equations(model), {1.0, 0.0});
        EXPECT_EQ(!growth_bands(wave, 0.0, {}).empty(), 1.0 + alpha * beta < 0.0);
        const SlowModes slow = slow_modes(wave);
        ASSERT_EQ(slow.modes.size(), 1u);
        EXPECT_NEAR(slow.modes[0].damping.real(), 1.0 + alpha * beta, 1e-13);
        EXPECT_LT(damping_error(wave, 0.0, slow.modes), 1e-4);
        // s^2 + 2 (1 + Q) s + 2 (1 + alpha beta) Q + (1 + alpha^2) Q^2 = 0 with Q = q^2.
        const double square = 0.3, sum = 1.0 + square,
                     product = 2.0 * (1.0 + alpha * beta) * square + (1.0 + alpha * alpha) * square * square;
        const Complex s = -sum + std::sqrt(Complex(sum * sum - product));
        EXPECT_NEAR(growth(wave, std::sqrt(square)).rate, s.real(), 1e-13);
    }
}

TEST(ModelGrowth, of_an_active_nematic_is_a_bend_for_extensile_and_a_splay_for_contractile_activity) {
    // d_t Q = (1 - 2 Q:Q) Q + K lap Q + sym grad v, Gamma v = zeta div Q, about Q_xx = 1/2: the director's angle
    // delta = Q_xy / (2 Q_xx) has v across from div Q; with v = zeta div Q/Gamma
    // d_t Q_xy = -K q^2 Q_xy + (1/2)(d_x v_y + d_y v_x) = -(K + zeta/(2 Gamma)) q^2 Q_xy: alike for bend and splay.
    // With d_t Q + omega rotation (corotation 2 Q_xx (d_x v_y - d_y v_x)/2) bend (q along x) and splay (q along y)
    // differ: -(zeta/2 Gamma)(1 + 2 Q_xx) and -(zeta/2 Gamma)(1 - 2 Q_xx), with Q_xx = S.
    const double zeta = -0.8, drag = 1.6, k = 0.1, s = std::sqrt(0.5);
    model::Model model{.fields = {spin(2, "Q", "(1 - Q:Q) Q + K lap Q + sym(grad v) + curl v perp Q"),
                                  spin(1, "v", "-Gamma v + zeta div Q")},
                       .coefficients = {{"K", k}, {"Gamma", drag}, {"zeta", zeta}}};
    model.fields[1].left = model::LeftSide::balance;
    const model::LinearisedAt state = about(model, 1);
    ASSERT_NEAR(state.about()[0], s, 1e-14);
    EXPECT_FALSE(state.is_isotropic());
    const double q = 0.3, active = zeta / (2.0 * drag);
    // Along x and along y, Q_xy couples to no other component.
    const double bend = -(k + active * (1.0 + 2.0 * s)) * q * q, splay = -(k + active * (1.0 - 2.0 * s)) * q * q;
    const auto has_rate = [&](double angle, double rate) {
        return (modes(state, state.wavevector(q, angle)).rates.array() - rate).abs().minCoeff();
    };
    EXPECT_LT(has_rate(0.0, bend), 1e-14);
    EXPECT_LT(has_rate(pi / 2.0, splay), 1e-14);
    EXPECT_GT(bend, 0.0);
    EXPECT_LT(splay, 0.0);
    EXPECT_FALSE(growth_bands(state, 0.0, {}).empty());
    EXPECT_TRUE(growth_bands(state, pi / 2.0, {.min = 1e-3, .max = 1.0}).empty());
}

TEST(ModelGrowth, about_an_isotropic_chiral_state_turns_the_order_and_no_flock_is_stationary) {
    // A rotation at the rate Omega mixes p_x and p_y: s = -a - q^2 +- i Omega.
    const model::Model model{.fields = {spin(1, "p", "-a p + 0.8 perp p - p.p p + lap p")},
                             .coefficients = {{"a", 0.3}},
                             .chiral = true};
    const model::LinearisedAt rest = about(model);
    EXPECT_TRUE(rest.is_isotropic());
    const Growth found = growth(rest, 0.5, 0.7);
    EXPECT_NEAR(found.rate, -0.55, 1e-14);
    EXPECT_NEAR(found.frequency, 0.8, 1e-14);
    model::Model turning = model;
    turning.coefficients["a"] = -0.3;
    const StationaryStates none = stationary_states(model::Equations(turning));
    EXPECT_EQ(names(none), std::vector<std::string>{"isotropic"});
    EXPECT_NE(none.why_no_order.find("found no ordered uniform state"), std::string::npos);
}

TEST(ModelGrowth, about_a_chiral_flock_is_its_closed_form) {
    // About p0 along x, with K_o lap perp p: s = -i w p0 q_x - a - K q^2 +- sqrt(a^2 - K_o^2 q^4).
    const double a = 0.6, k = 0.05, odd = 0.7, w = 0.4, p0 = std::sqrt(a);
    const model::LinearisedAt flock =
        about({.fields = {spin(1, "p", "(a - p.p) p + K lap p + Ko lap perp p - w p.grad p")},
               .coefficients = {{"a", a}, {"K", k}, {"Ko", odd}, {"w", w}},
               .chiral = true},
              1);
    ASSERT_NEAR(flock.about()[0], p0, 1e-14);
    for (const double q : {0.2, 0.9, 2.0}) {
        const double angle = 0.6, square = a * a - odd * odd * std::pow(q, 4);
        const Complex s = Complex(-a - k * q * q, -w * p0 * q * std::cos(angle)) + std::sqrt(Complex(square));
        EXPECT_NEAR(growth(flock, q, angle).rate, s.real(), 1e-13);
    }
}

TEST(ModelGrowth, is_the_sum_of_the_shares_of_terms_also_through_fields_in_balance) {
    model::Model model{.fields = {scalar("sigma", "-div(sigma p) + 0.2 lap sigma"),
                                  spin(1, "p", "-(0.4 + p.p) p + 0.7 lap p + lambda v - 0.5 sigma grad sigma"),
                                  spin(1, "v", "-Gamma v + eta lap v + alpha p - E grad sigma")},
                       .coefficients = {{"lambda", 1.3}, {"Gamma", 2.0}, {"eta", 0.6}, {"alpha", 1.8}, {"E", 0.9}}};
    model.fields[0].reference = 1.1;
    model.fields[2].left = model::LeftSide::balance;
    const model::Equations equations(model);
    const StationaryStates found = stationary_states(equations);
    ASSERT_EQ(found.states.size(), 2u);
    const model::LinearisedAt flock(equations, found.states[1].values);
    const Wavevector q = flock.wavevector(0.4, 0.8);
    const Modes all = modes(flock, q);
    for (std::size_t mode = 0; mode < 3; ++mode) {
        const std::vector<Complex> shares = term_shares(flock, q, mode);
        const Complex sum = std::accumulate(shares.begin(), shares.end(), Complex());
        EXPECT_LT(std::abs(sum - all.rates(static_cast<Eigen::Index>(mode))), 1e-13);
        // The share of a term is the derivative of the rate by the logarithm of its factor, at the same state.
        for (const auto& [name, term] : {std::pair{"lambda", 4u}, {"alpha", 8u}}) {  // with a rate, and in balance
            ASSERT_EQ(equations.terms()[term].text, name == std::string("lambda") ? "+ lambda v" : "+ alpha p");
            constexpr double step = 1e-5;
            std::array<Complex, 2> rates;
            for (const int side : {0, 1}) {
                model::Model changed = model;
                changed.coefficients[name] *= 1.0 + (side == 0 ? -step : step);
                const Eigen::VectorXcd near =
                    modes(model::LinearisedAt(model::Equations(changed), flock.about()), q).rates;
                Eigen::Index at = 0;
                (near.array() - all.rates(static_cast<Eigen::Index>(mode))).abs().minCoeff(&at);
                rates[static_cast<std::size_t>(side)] = near(at);
            }
            // The difference quotient has an error of step^2 and rounding over the step.
            EXPECT_LT(std::abs((rates[1] - rates[0]) / (2.0 * step) - shares[term]), 1e-9) << name;
        }
    }
}

TEST(ModelGrowth, of_more_components_than_the_precise_eigenvalues_hold_is_that_of_each_of_them) {
    model::Model model;
    for (const int k : {1, 2, 3, 4}) {
        const std::string p = text("p{}", k);
        model.fields.push_back(spin(1, p, text("{} {} + {} lap {} + grad(div {})", 0.1 * k - 0.3, p, 0.5 * k, p, p)));
    }
    const model::LinearisedAt rest = about(model);
    const double square = 0.36;
    std::vector<double> expected;
    for (const int k : {1, 2, 3, 4})
        for (const double splay : {0.0, 1.0}) expected.push_back(0.1 * k - 0.3 - (0.5 * k + splay) * square);
    std::sort(expected.rbegin(), expected.rend());
    const Modes found = modes(rest, rest.wavevector(0.6, 0.9));
    for (Eigen::Index k = 0; k < 8; ++k)
        EXPECT_LT(std::abs(found.rates(k) - expected[static_cast<std::size_t>(k)]), 1e-14);
    EXPECT_NEAR(growth(rest, 0.0).rate, 0.1, 1e-15);
}

TEST(LinearisedAt, has_the_symbol_of_the_equations) {
    model::Model model{.fields = {scalar("sigma", "-div(sigma p) + 0.2 lap sigma"),
                                  spin(1, "p", "-(0.4 + p.p) p - p.grad p + 0.7 lap p + v - 0.5 sigma grad sigma"),
                                  spin(1, "v", "-2 v + lap v + p")}};
    model.fields[2].left = model::LeftSide::balance;
    const model::Equations equations(model);
    const model::LinearisedAt at(equations, {0.9, 0.5, 0.2, 0.0, 0.0});
    EXPECT_FALSE(at.is_isotropic());
    EXPECT_NEAR(at.direction(), std::atan2(0.2, 0.5), 1e-15);
    const std::vector<int>& state = equations.state_components();
    for (const Wavevector q : {Wavevector{0.0, 0.0}, {0.7, -0.3}, {2.0, 5.0}}) {
        const model::Symbol expected = equations.symbol(at.about(), q)(state, state);
        EXPECT_LT((at.symbol(q) - expected).norm(), 1e-14 * expected.norm());  // another order of the sums
    }
}

// ---- fluctuations

TEST(ModelFluctuations, of_edwards_wilkinson_and_of_model_b_are_their_closed_forms) {
    model::Model surface{.fields = {scalar("h", "nu lap h")}, .coefficients = {{"nu", 0.7}}};
    surface.fields[0].noise = 0.3;
    model::Model separation{.fields = {scalar("phi", "lap(a phi + phi^3 - K lap phi)")},
                            .coefficients = {{"a", 0.4}, {"K", 1.7}}};
    separation.fields[0].noise = 0.3, separation.fields[0].noise_conserves = true, separation.fields[0].reference = 0.5;
    const numerics::Grid grid{.nx = 16, .ny = 12, .lx = 9.0, .ly = 7.0};
    Threads threads(2);
    const model::LinearisedAt flat(model::Equations(surface), {0.0}), mixed(model::Equations(separation), {0.5});
    const StructureFactors h = structure_factors(flat, grid, 3, threads),
                           phi = structure_factors(mixed, grid, 3, threads),
                           some = structure_factors(mixed, grid, 3, threads, [](std::size_t m) { return m % 2 == 0; });
    ASSERT_EQ(h.why_none + phi.why_none, "");
    EXPECT_EQ(phi.names, std::vector<std::string>{"phi"});
    for (std::size_t row = 0; row < 12; ++row)
        for (std::size_t column = 0; column < 9; ++column) {
            const Wavevector q = numerics::wavevector(grid, column, row);
            const double square = q.x * q.x + q.y * q.y;
            const bool kept = numerics::is_kept(grid, 3, column, row) && square > 0.0;
            const std::size_t mode = row * 9 + column;
            const double expected_h = kept ? 0.3 / (2.0 * 0.7 * square) : 0.0;
            const double expected_phi = kept ? 0.3 / (2.0 * (0.4 + 3.0 * 0.25 + 1.7 * square)) : 0.0;
            EXPECT_NEAR(h.at(mode, 0, 0).real(), expected_h, 1e-14 * expected_h);
            EXPECT_EQ(some.at(mode, 0, 0), mode % 2 == 0 ? phi.at(mode, 0, 0) : 0.0);
            EXPECT_NEAR(phi.at(mode, 0, 0).real(), expected_phi, 1e-14 * expected_phi);
        }
}

model::Model noisy_flock() {
    model::Model model{.fields = {scalar("sigma", "-div(sigma p) + 0.2 lap sigma"),
                                  spin(1, "p", "(0.4 - p.p) p - 0.3 p.grad p + 0.7 lap p + v - 0.9 grad sigma"),
                                  spin(1, "v", "-2 v + lap v + p")}};
    model.fields[0].reference = 1.2;
    model.fields[0].noise = 0.05, model.fields[0].noise_conserves = true;
    model.fields[1].noise = 0.2;
    model.fields[2].left = model::LeftSide::balance;
    return model;
}

TEST(ModelFluctuations, in_time_integrate_to_those_at_equal_times_fields_in_balance_included) {
    const model::Equations equations(noisy_flock());
    const model::LinearisedAt flock(equations, stationary_states(equations).states.at(1).values);
    const Wavevector q = flock.wavevector(0.5, 1.0);
    // omega = tan(x): the integrand is periodic and smooth in x, so that equal steps converge faster than any power.
    model::Symbol sum = model::Symbol::Zero(5, 5);
    constexpr int count = 2000;
    for (int n = 0; n < count; ++n) {
        const double x = pi * ((n + 0.5) / count - 0.5), c = std::cos(x);
        sum += dynamic_structure(flock, q, std::tan(x)) / (c * c) * (pi / count) / (2.0 * pi);
    }
    const Covariance found = covariance(flock, q);
    ASSERT_EQ(found.why_none, "");
    EXPECT_LT((sum - found.matrix).norm(), 1e-10 * found.matrix.norm());
    // The Lyapunov equation itself, of the components with a rate.
    const std::vector<int>& state = equations.state_components();
    const model::Symbol s = found.matrix(state, state), m = flock.symbol(q);
    EXPECT_LT((m * s + s * m.adjoint() + flock.noise(q)).norm(), 1e-13 * m.norm() * s.norm());
    EXPECT_NEAR(found.matrix(3, 1).real(), (s(1, 1) / 2.25).real(), 1e-14);  // v = p/(2 + q^2)
}

TEST(ModelFluctuations, along_and_across_q_do_not_depend_on_the_direction_of_q_about_an_isotropic_state) {
    model::Model model = noisy_flock();
    model.fields[1].equation.text = "-(0.9 + p.p) p - 0.3 p.grad p + 0.7 lap p + v - 0.9 grad sigma";
    const model::Equations equations(model);
    const model::LinearisedAt rest(equations, stationary_states(equations).states.at(0).values);
    EXPECT_EQ(part_names(equations), (std::vector<std::string>{"sigma", "p_along", "p_across", "v_along", "v_across"}));
    const numerics::Grid grid{.nx = 12, .ny = 12, .lx = 20.0, .ly = 15.0};
    Threads threads(1);
    const StructureFactors found = structure_factors(rest, grid, 2, threads);
    ASSERT_EQ(found.why_none, "");
    const std::size_t column = 1, row = 2, mode = row * 7 + column;
    const Wavevector q = numerics::wavevector(grid, column, row);
    const model::Symbol here = rest.along_and_across(covariance(rest, q).matrix, q);
    for (std::size_t i = 0; i < 5; ++i)
        for (std::size_t j = 0; j < 5; ++j)
            EXPECT_LT(std::abs(found.at(mode, i, j) - here(static_cast<int>(i), static_cast<int>(j))),
                      1e-13 * here.norm());
    const double square = q.x * q.x + q.y * q.y;  // across: -(0.9 + 0.7 q^2 - 1/(2 + q^2)) alone
    EXPECT_NEAR(found.at(mode, 2, 2).real(), 0.1 / (0.9 + 0.7 * square - 1.0 / (2.0 + square)), 1e-13);
}

TEST(ModelTerms, are_rejected_by_a_number_that_none_has_and_with_another_number_of_factors) {
    const model::Equations equations(model::Model{.fields = {scalar("phi", "phi - phi^3 + lap phi")}});
    const model::UniformState rest{0.5};
    const std::size_t terms = equations.terms().size();
    EXPECT_THROW(equations.term_symbol(terms, rest, {1.0, 0.0}), Error);
    EXPECT_THROW(model::LinearisedAt(equations, rest).term_symbol(terms, {1.0, 0.0}), Error);
    EXPECT_NO_THROW(equations.term_symbol(terms - 1, rest, {1.0, 0.0}));
    for (const std::size_t count : {terms - 1, terms + 1}) {
        const std::vector<double> factors(count, 1.0);
        EXPECT_THROW(equations.uniform_rates(rest, factors), Error);
        EXPECT_THROW(model::LinearisedAt(equations, rest,
                                         {.factors = factors, .mass_density = Eigen::VectorXd::Ones(1)}),
                     Error);
    }
    EXPECT_EQ(equations.uniform_rates(rest, std::vector<double>(terms, 1.0)), equations.uniform_rates(rest));
}

TEST(ModelFluctuations, have_no_stationary_state_where_a_mode_grows_or_a_marginal_one_has_noise) {
    model::Model model{.fields = {scalar("phi", "a phi + lap phi"), scalar("psi", "-psi + lap psi"),
                                  scalar("c", "-lap c")},
                       .coefficients = {{"a", 0.25}}};
    model.fields[2].equation.text = "";  // the rate 0 at every q
    model.fields[0].noise = model.fields[1].noise = 0.1;
    const model::UniformState rest{0.0, 0.0, 0.0};
    const auto found = [&](double q) {
        return covariance(model::LinearisedAt(model::Equations(model), rest), {q, 0.0});
    };
    EXPECT_EQ(found(0.1).why_none, "no stationary state: a mode at q = (0.1, 0) grows at the rate 0.24");
    EXPECT_TRUE(found(0.5).why_none.starts_with(
        "no stationary state: noise drives a mode at q = (0.5, 0), which does not decay"));
    const Covariance decays = found(0.7);  // c neither decays nor fluctuates
    ASSERT_EQ(decays.why_none, "");
    EXPECT_NEAR(decays.matrix(0, 0).real(), 0.05 / (0.49 - 0.25), 1e-14);
    EXPECT_NEAR(decays.matrix(1, 1).real(), 0.05 / 1.49, 1e-15);
    EXPECT_EQ(decays.matrix(2, 2), 0.0);
    const numerics::Grid grid{.nx = 8, .ny = 8, .lx = 40.0, .ly = 40.0};
    Threads threads(1);
    const StructureFactors none =
        structure_factors(model::LinearisedAt(model::Equations(model), rest), grid, 1, threads);
    EXPECT_TRUE(none.values.empty());
    EXPECT_NE(none.why_none.find("grows at the rate"), std::string::npos);
}

// ---- long waves

TEST(ModelSlowModes, of_a_flock_are_the_sound_of_toner_and_tu) {
    // d_t n = -div(n p), d_t p = -lambda p.grad p + (a - b p^2) p - c grad n, about n0 and p0 along x: in the limit of
    // long waves delta p_x follows from delta n (here not at all: a and b are constants), so that with U the speed
    //     (U - p0 cos)(U - lambda p0 cos) = c n0 sin^2.
    const double a = 0.8, b = 0.5, lambda = 0.35, c = 0.9, n0 = 1.3, p0 = std::sqrt(a / b);
    model::Model model{.fields = {scalar("n", "-div(n p)"),
                                  spin(1, "p", "-lambda p.grad p + (a - b p.p) p - c grad n")},
                       .coefficients = {{"a", a}, {"b", b}, {"lambda", lambda}, {"c", c}}};
    model.fields[0].reference = n0;
    const model::LinearisedAt flock = about(model, 1);
    for (const double angle : {0.3, 1.0, pi / 2.0, 2.5}) {
        const SlowModes slow = slow_modes(flock, angle);
        ASSERT_EQ(slow.why_none, "");
        ASSERT_EQ(slow.modes.size(), 2u);
        const double mean = 0.5 * (1.0 + lambda) * p0 * std::cos(angle),
                     half = std::sqrt(std::pow(0.5 * (1.0 - lambda) * p0 * std::cos(angle), 2) +
                                      c * n0 * std::pow(std::sin(angle), 2));
        EXPECT_LT(std::abs(slow.modes[0].speed - (mean - half)), 1e-13);
        EXPECT_LT(std::abs(slow.modes[1].speed - (mean + half)), 1e-13);
        EXPECT_LT(damping_error(flock, angle, slow.modes), 1e-3);
    }
}

TEST(ModelSlowModes, of_densities_that_an_incompressible_flow_carries_are_theirs_at_every_angle) {
    // div u = 0, so that to first order nothing carries a uniform density: diffusion is left.
    model::Model model{.fields = {scalar("n", "-div(n u) + 0.2 lap n"), scalar("m", "-div(m u) + 3 lap m"),
                                  spin(1, "u", "lap u + n grad lap n")}};
    model.fields[0].conserved = model.fields[1].conserved = true;
    model.fields[2].left = model::LeftSide::balance;
    model.fields[2].solenoidal = true;
    for (const double n0 : {0.7, 1.1, 1.9}) {
        model.fields[0].reference = n0, model.fields[1].reference = 0.3 * n0;
        const model::Equations equations(model);
        const model::LinearisedAt at(equations, equations.reference());
        for (const double angle : {0.0, pi / 6.0, 1.0, pi / 3.0, pi / 2.0}) {
            const SlowModes slow = slow_modes(at, angle);
            ASSERT_EQ(slow.modes.size(), 2u) << n0 << " " << angle << " " << slow.why_none;
            EXPECT_NEAR(slow.modes[0].damping.real(), 0.2, 1e-13);
            EXPECT_NEAR(slow.modes[1].damping.real(), 3.0, 1e-12);
        }
    }
}

TEST(ModelSlowModes, of_a_balance_that_is_empty_at_q_0_are_refused_for_that_reason) {
    model::Model model{.fields = {scalar("u", "-u + lap u + lap psi"), scalar("psi", "lap psi + lap u")}};
    model.fields[1].left = model::LeftSide::balance;
    const SlowModes slow = slow_modes(model::LinearisedAt(model::Equations(model), {0.0, 0.0}));
    EXPECT_NE(slow.why_none.find("a balance leaves its field free at q = 0"), std::string::npos) << slow.why_none;
}

TEST(ModelSlowModes, of_coupled_diffusion_are_the_eigenvalues_of_its_matrix) {
    model::Model model{.fields = {scalar("u", "2 lap u + 0.5 lap v"), scalar("v", "0.4 lap u + lap v - 0.1 lap lap v"),
                                  scalar("w", "-3 w + lap u")}};
    const model::LinearisedAt mixture(model::Equations(model), {0.0, 0.0, 0.0});
    const SlowModes slow = slow_modes(mixture);
    ASSERT_EQ(slow.why_none, "");
    ASSERT_EQ(slow.modes.size(), 2u);
    const double root = std::sqrt(0.25 + 0.2);  // of the matrix (2, 0.5; 0.4, 1)
    for (const int k : {0, 1}) {
        const SlowMode& mode = slow.modes[static_cast<std::size_t>(k)];
        EXPECT_EQ(mode.speed, 0.0);
        EXPECT_LT(std::abs(mode.damping - (1.5 + (k == 0 ? -root : root))), 1e-14);
    }
    EXPECT_LT(damping_error(mixture, 0.0, slow.modes), 1e-6);  // the next term, 0.1 q^2, and rounding over q^2
}

TEST(ModelSlowModes, of_damped_sound_diffuse_and_of_a_threshold_do_not_exist) {
    // n0 c/gamma is the diffusion constant of a gas whose velocity follows its pressure.
    model::Model model{.fields = {scalar("n", "-div(n v)"), spin(1, "v", "-gamma v - c grad n")},
                       .coefficients = {{"gamma", 0.7}, {"c", 1.9}}};
    model.fields[0].reference = 1.4;
    const model::LinearisedAt gas(model::Equations(model), {1.4, 0.0, 0.0});
    const SlowModes slow = slow_modes(gas);
    ASSERT_EQ(slow.modes.size(), 1u);
    EXPECT_LT(std::abs(slow.modes[0].damping - 1.4 * 1.9 / 0.7), 1e-13);
    model::Model driven{
        .fields = {scalar("u", "w"), scalar("w", "lap u - lap w")}};  // d_t u = w: a Jordan block at q = 0
    EXPECT_NE(slow_modes(model::LinearisedAt(model::Equations(driven), {0.0, 0.0})).why_none.find("no power series"),
              std::string::npos);
}

TEST(ModelTheory, rejects_numbers_states_and_matrices_that_the_model_does_not_have) {
    const model::Equations equations(model::Model{.fields = {scalar("phi", "phi - phi^3 + lap phi")}});
    const model::UniformState rest{0.5}, nothing, unknown{NAN};
    for (const std::size_t n : {equations.terms().size(), std::size_t{9}}) {
        EXPECT_THROW(static_cast<void>(equations.has_derivative(n, rest)), Error);
        EXPECT_THROW(static_cast<void>(equations.is_isotropic(n)), Error);
        EXPECT_THROW(equations.only(n), Error);
    }
    EXPECT_THROW(equations.latex(1), Error);
    EXPECT_THROW(equations.varying_mass(1, rest), Error);
    for (const model::UniformState& state : {nothing, unknown, {0.5, 0.5}}) {
        EXPECT_THROW(equations.about(state), Error);
        EXPECT_THROW(equations.noise(state, {1.0, 0.0}), Error);
        EXPECT_THROW(model::direction_of(equations.model(), state), Error);
        EXPECT_THROW(stationary_states_near(equations, rest, {state}), Error);
    }
    EXPECT_THROW(nearest_state(stationary_states(equations), equations.model(), {rest, nothing}), Error);
    EXPECT_THROW(model::LinearisedAt(equations, rest, model::LeftSides{}), Error);
    for (const auto& [masses, noises] : {std::pair{3, 0}, {1, 2}})
        EXPECT_THROW(model::LinearisedAt(equations, rest,
                                         {.mass_density = Eigen::VectorXd::Ones(masses),
                                          .noise = Eigen::VectorXd::Zero(noises)}),
                     Error);
    const model::LinearisedAt at(equations, rest);
    EXPECT_THROW(at.along_and_across(model::Symbol::Zero(2, 2), {1.0, 0.0}), Error);
    EXPECT_THROW(at.of_forces(Eigen::RowVectorXcd::Zero(2), {1.0, 0.0}), Error);
    for (const Eigen::Index mode : {-1, 1}) EXPECT_THROW(modes(at, {1.0, 0.0}).frequency(mode), Error);
    for (const double interval : {-0.5, static_cast<double>(NAN)})
        EXPECT_THROW(lagged_covariances(at, {2.0, 0.0}, interval, 2), Error);
}

}  // namespace
}  // namespace drover::theory::theory_tests
