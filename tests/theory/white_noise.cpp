// tests/theory/white_noise.cpp: white noises that equations name: shared, random fluxes, coloured; what is rejected.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "drover/model/evolution.hpp"
#include "drover/model/linearised_at.hpp"
#include "drover/theory/theory.hpp"

namespace drover::model::white_noise_tests {
namespace {

using numerics::Wavevector;
using Complex = std::complex<double>;

Field scalar(const std::string& symbol, const std::string& equation) {
    return {.name = symbol, .symbol = symbol, .equation = {equation, {.file = "model", .line = 1, .column = 1}}};
}

Symbol stationary(const Model& model, const Wavevector& q) {
    const Equations equations(model);
    const theory::Covariance found = theory::covariance(LinearisedAt(equations, equations.reference()), q);
    EXPECT_EQ(found.why_none, "");
    return found.matrix;
}

Symbol noise_of(const Model& model, const Wavevector& q) {
    const Equations equations(model);
    return equations.noise(equations.reference(), q);
}

/// Two scalars that share a noise, of which one has a noise of its own too.
Model shared() {
    return {.fields = {scalar("a", "-k a + lap a + s xi + r zeta"), scalar("b", "-2 k b + 0.5 lap b - 0.7 xi")},
            .definitions = {},
            .coefficients = {{"k", 0.4}, {"s", 1.3}, {"r", 0.6}},
            .noises = {{.symbol = "xi"}, {.symbol = "zeta"}}};
}

TEST(WhiteNoise, that_two_fields_share_correlates_them) {
    // d_t a = -x a + s xi + r zeta, d_t b = -y b - 0.7 xi: <a b> = -0.7 s/(x + y), <a a> = (s^2 + r^2)/2x.
    const Wavevector q{0.6, -0.8};
    const double x = 0.4 + 1.0, y = 0.8 + 0.5;
    const Symbol found = stationary(shared(), q);
    EXPECT_NEAR(found(0, 0).real(), (1.3 * 1.3 + 0.6 * 0.6) / (2.0 * x), 1e-14);
    EXPECT_NEAR(found(1, 1).real(), 0.49 / (2.0 * y), 1e-14);
    EXPECT_NEAR(found(0, 1).real(), -0.7 * 1.3 / (x + y), 1e-14);
    EXPECT_LT(std::abs(found(0, 1).imag()), 1e-14);
}

TEST(WhiteNoise, that_exchanges_two_fields_has_spectra_though_their_sum_neither_decays_nor_is_driven) {
    // Of a - b: d_t (a - b) = -(k + l)(a - b) + 2 s xi + (l - k)(a + b), and a + b is 0.  The rate 0 of a + b is one of
    // rounding errors, on either side of 0 by the coefficients.
    const double s = 0.7, tau = 0.2, omega = 0.3;
    const Wavevector q{0.785, 0.0};
    for (const auto& [k, l] : {std::pair{0.245, 0.973}, {0.136, 0.576}, {0.561, 0.955}, {0.4, 0.9}, {0.31, 0.17}}) {
        const Model exchange{.fields = {scalar("a", "-k a + l b + s xi"), scalar("b", "k a - l b - s xi"),
                                        scalar("c", "0.9 a - c")},
                             .definitions = {},
                             .coefficients = {{"k", k}, {"l", l}, {"s", s}},
                             .noises = {{.symbol = "xi"}}};
        const Equations equations(exchange);
        const LinearisedAt rest(equations, equations.reference());
        const double decay = k + l, size = s * s / (2.0 * decay);
        const theory::Correlations lagged = theory::lagged_covariances(rest, q, tau, 4);
        ASSERT_EQ(lagged.why_none, "");
        for (int n = 0; n < 4; ++n)
            EXPECT_NEAR(lagged.matrices[static_cast<std::size_t>(n)](0, 0).real(), size * std::exp(-decay * tau * n),
                        1e-12 * size);
        const theory::Correlations spectra = theory::dynamic_structures(rest, q, {0.0, omega});
        ASSERT_EQ(spectra.why_none, "");
        EXPECT_NEAR(spectra.matrices[0](0, 0).real() * decay * decay, s * s, 1e-12 * s * s);
        EXPECT_NEAR(spectra.matrices[1](0, 0).real() * (omega * omega + decay * decay), s * s, 1e-12 * s * s);
    }
}

TEST(WhiteNoise, that_drives_a_wave_which_does_not_decay_has_no_spectra_and_says_why) {
    const Model drift{.fields = {scalar("a", "s xi")},
                      .definitions = {},
                      .coefficients = {{"s", 1.0}},
                      .noises = {{.symbol = "xi"}}};
    const Equations equations(drift);
    const LinearisedAt rest(equations, equations.reference());
    const theory::Correlations lagged = theory::lagged_covariances(rest, {0.5, 0.0}, 0.1, 4),
                               spectra = theory::dynamic_structures(rest, {0.5, 0.0}, {1.0});
    EXPECT_TRUE(lagged.matrices.empty() && spectra.matrices.empty());
    EXPECT_TRUE(lagged.why_none.starts_with("no stationary state: noise drives a mode at q = (0.5, 0)"));
    EXPECT_EQ(lagged.why_none, spectra.why_none);
}

TEST(WhiteNoise, correlates_the_modes_of_a_run_as_theory_says) {
    const numerics::Grid grid{.nx = 16, .ny = 16, .lx = 12.0, .ly = 12.0};
    Evolution run(Equations(shared()), {.grid = grid, .dt = 4.0});
    double a = 0.0, b = 0.0, ab = 0.0;
    constexpr int samples = 400;
    for (int n = 0; n < samples; ++n) {
        run.advance(1);
        const numerics::Fields fields = run.fields();
        for (std::size_t i = 0; i < numerics::points(grid); ++i)
            a += fields[0][i] * fields[0][i], b += fields[1][i] * fields[1][i], ab += fields[0][i] * fields[1][i];
    }
    double expected = 0.0;
    for (int j = -7; j <= 7; ++j)
        for (int i = -7; i <= 7; ++i) {
            const double q = 2.0 * std::numbers::pi / 12.0, square = q * q * (i * i + j * j);
            expected += -0.7 * 1.3 / (1.2 + 1.5 * square) / 144.0;
        }
    // The steps are of 1.6 and more decay times, so that the samples of the modes, which are some 100 that count, are
    // nearly independent: of 4e4 numbers the correlation is known to 1 %; a fifth of it is far outside.
    const double number = samples * static_cast<double>(numerics::points(grid));
    EXPECT_NEAR(ab / number, expected, 0.05 * std::abs(expected));
    EXPECT_LT(ab * ab, a * b);
}

TEST(WhiteNoise, of_a_random_flux_is_conserved_noise) {
    Model flux{.fields = {scalar("c", "lap(c + c^3 - lap c) + sqrt(2 T) div xi")},
               .definitions = {},
               .coefficients = {{"T", 0.3}},
               .noises = {{.symbol = "xi", .spin = 1}}};
    flux.fields[0].conserved = true;
    Model same = flux;
    same.noises = {};
    same.fields[0] = scalar("c", "lap(c + c^3 - lap c)");
    same.fields[0].noise = 0.6;
    same.fields[0].noise_conserves = true;
    for (const Wavevector& q : {Wavevector{0.0, 0.0}, Wavevector{0.3, 0.0}, Wavevector{-0.8, 1.1}})
        EXPECT_LT((noise_of(flux, q) - noise_of(same, q)).norm(), 1e-15);
    EXPECT_EQ(Equations(flux).terms().size(), 1u);
    ASSERT_EQ(Equations(flux).noise_terms().size(), 1u);
    EXPECT_EQ(Equations(flux).noise_terms()[0].text, "+ sqrt(2 T) div xi");
}

TEST(WhiteNoise, of_a_density_and_its_current_turns_with_the_wave) {
    // A flux that drives the current too: <f_rho f_p*> = i q g, f_p = g xi.
    const Model model{.fields = {scalar("rho", "-div p + div xi"),
                                 {.name = "p", .symbol = "p", .spin = 1, .equation = {"-p - grad rho + 0.5 xi", {}}}},
                      .definitions = {},
                      .coefficients = {},
                      .noises = {{.symbol = "xi", .spin = 1}}};
    const Equations equations(model);
    const Wavevector q{0.3, 0.4};
    const Symbol noise = noise_of(model, q);
    EXPECT_LT(std::abs(noise(0, 0) - 0.25), 1e-15);
    EXPECT_LT(std::abs(noise(0, 1) - Complex(0.0, 0.5 * 0.3)), 1e-15);
    EXPECT_LT(std::abs(noise(0, 2) - Complex(0.0, 0.5 * 0.4)), 1e-15);
    EXPECT_LT(std::abs(noise(1, 2)), 1e-15);
    // The equal-time correlations of the solver are those of the Lyapunov equation at every direction of q.
    const Symbol s = stationary(model, q), m = equations.symbol(equations.reference(), q);
    EXPECT_LT((m * s + s * m.adjoint() + noise).norm(), 1e-14);
    const numerics::System system = equations.linear_system({.nx = 8, .ny = 8, .lx = 9.0, .ly = 9.0});
    const numerics::IsotropicBlocks blocks = system.noise(0.5);
    EXPECT_NEAR(blocks.even(0, 1) * blocks.even(0, 1), blocks.even(0, 0) * blocks.even(1, 1), 1e-15);  // one noise
    EXPECT_NEAR(blocks.even(0, 1), blocks.even(1, 0), 1e-15);
}

TEST(WhiteNoise, through_a_field_of_its_own_is_coloured) {
    // d_t phi = -x phi + eta, d_t eta = (-eta + sqrt(2 A) xi)/tau: <eta eta> = A/tau, <phi phi> = A/(x (1 + x tau)).
    const double A = 0.7, tau = 2.0, k = 0.5, q = 0.9, x = k + q * q;
    const Model model{.fields = {scalar("phi", "-k phi + lap phi + eta"),
                                 scalar("eta", "-eta / tau + sqrt(2 A) / tau xi")},
                      .definitions = {},
                      .coefficients = {{"A", A}, {"tau", tau}, {"k", k}},
                      .noises = {{.symbol = "xi"}}};
    const Symbol found = stationary(model, {q, 0.0});
    EXPECT_NEAR(found(1, 1).real(), A / tau, 1e-14);
    EXPECT_NEAR(found(0, 0).real(), A / (x * (1.0 + x * tau)), 1e-14);
    // Steps longer than every time of the model make no error: two of them follow the path of one.
    const numerics::Grid grid{.nx = 8, .ny = 8, .lx = 9.0, .ly = 9.0};
    Evolution whole(Equations(model), {.grid = grid, .dt = 6.0}), halves(Equations(model), {.grid = grid, .dt = 3.0});
    whole.advance(2), halves.advance(4);
    const numerics::Fields one = whole.fields(), other = halves.fields();
    for (std::size_t i = 0; i < one.values.size(); ++i) EXPECT_NEAR(one.values[i], other.values[i], 1e-13);
}

TEST(WhiteNoise, is_divided_by_a_mass_unless_it_is_an_acceleration) {
    const auto strength = [](const std::string& noise) {
        Model model{.fields = {scalar("v", "-v + " + noise)},
                    .definitions = {},
                    .coefficients = {{"m", 4.0}},
                    .noises = {{.symbol = "xi"}}};
        model.fields[0].mass = {"m", {}};
        return noise_of(model, {1.0, 0.0})(0, 0).real();
    };
    EXPECT_DOUBLE_EQ(strength("xi"), 1.0 / 16.0);
    EXPECT_DOUBLE_EQ(strength("m xi"), 1.0);
}

/// The message with which a model with a vector noise xi, a scalar noise zeta and a pseudoscalar chi is rejected.
std::string rejection_of(const std::string& equation, const std::function<void(Model&)>& change = {}) {
    Model model{.fields = {scalar("a", equation),
                           {.name = "b",
                            .symbol = "b",
                            .left = LeftSide::balance,
                            .equation = {"-b + lap a", {.file = "model", .line = 2, .column = 1}}}},
                .definitions = {},
                .coefficients = {},
                .noises = {{.symbol = "xi", .spin = 1, .where = {.file = "model", .line = 3, .column = 1}},
                           {.symbol = "zeta", .where = {.file = "model", .line = 4, .column = 1}},
                           {.symbol = "chi", .odd = true, .where = {.file = "model", .line = 5, .column = 1}}}};
    if (change) change(model);
    try {
        const Equations equations(model);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(WhiteNoise, that_does_not_fit_is_rejected_at_its_place) {
    EXPECT_EQ(rejection_of("-a + zeta"), "");
    EXPECT_NE(rejection_of("-a + xi").find("a vector"), std::string::npos) << rejection_of("-a + xi");
    EXPECT_NE(rejection_of("-a + chi").find("pseudoscalar"), std::string::npos) << rejection_of("-a + chi");
    EXPECT_NE(rejection_of("-a + d_x zeta").find("isotropic noise"), std::string::npos);
    const auto conserved = [](Model& model) { model.fields[0].conserved = true; };
    EXPECT_EQ(rejection_of("lap a + div xi + lap zeta", conserved), "");
    EXPECT_NE(rejection_of("lap a + zeta", conserved).find("no divergence"), std::string::npos);
    const auto in_balance = [](Model& model) { model.fields[1].equation.text = "-b + lap a + zeta"; };
    EXPECT_NE(rejection_of("-a", in_balance).find("in balance"), std::string::npos);
    const auto twice = [](Model& model) { model.noises[1].symbol = "a"; };
    EXPECT_NE(rejection_of("-a", twice).find("used twice"), std::string::npos);
}

}  // namespace
}  // namespace drover::model::white_noise_tests
