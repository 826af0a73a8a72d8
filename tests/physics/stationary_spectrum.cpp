// tests/physics/stationary_spectrum.cpp: the noisy linear model stays in the stationary law of its Lyapunov equation, at any step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/numerics/wavenumbers.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {
namespace {

using numerics::Complex;

const Model model{.uniform = {.rod_density = 1.0},
                  .current = {.speed = 1.5},
                  .relaxation = {.rate = 0.4},
                  .elasticity = {.stiffness = 0.7, .splay = 0.3},
                  .pressure = {.rods = 0.8},
                  .diffusion = {.rods = 0.05},
                  .noise = {.order = 0.3, .rods = 0.1}};
constexpr numerics::Grid grid{16, 12, 9.0, 7.0};

// Regularised upper incomplete gamma function: probability that a chi-square of 2 a degrees exceeds 2 x.  Series below a + 1,
// continued fraction above (Abramowitz & Stegun 6.5.29, 6.5.31).
double upper_gamma(double a, double x) {
    if (x <= 0.0) return 1.0;
    const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; term > 1e-17 * sum; n += 1.0) sum += term *= x / n;
        return 1.0 - front * sum;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for (int n = 1; n < 100000; ++n) {
        const double an = -n * (n - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        const double factor = d * c;
        h *= factor;
        if (std::abs(factor - 1.0) < 1e-16) break;
    }
    return front * h;
}

/// Two-sided probability of a sum of squares of `degrees` standard normal numbers.
double two_sided(double squares, double degrees) {
    const double above = upper_gamma(0.5 * degrees, 0.5 * squares);
    return 2.0 * std::min(above, 1.0 - above);
}

TEST(ChiSquare, has_the_tails_of_the_tables) {
    EXPECT_NEAR(upper_gamma(0.5, 0.5 * 3.841458820694124), 0.05, 1e-12);
    EXPECT_NEAR(upper_gamma(5.0, 0.5 * 23.209251158954356), 0.01, 1e-12);
    EXPECT_NEAR(upper_gamma(5.0, 0.5 * 3.940299136119), 0.95, 1e-9);
}

/// One mode in independent variables of unit variance: w = f z, with f f^T = S/area, found by forward substitution.
struct Whitened {
    std::array<Complex, 3> z;  // two along q, one across
};

/// A lower-triangular root of a 2 by 2 covariance, by its closed form.
std::array<double, 3> root(const numerics::Block& s) {
    const double a = std::sqrt(s(0, 0)), b = s(1, 0) / a;
    return {a, b, std::sqrt(s(1, 1) - b * b)};
}

/// Sums of squares over realisations, of every mode and every pair of its variables.
struct Tally {
    std::vector<std::array<double, 9>>
        of_mode;  // |z1|^2, |z2|^2, |z3|^2, then |zi + zj|^2/2 and |zi + i zj|^2/2 of the pairs
    double whole = 0.0, mean_order = 0.0;
    int realisations = 0;
};

/// Modes that stand for themselves and their conjugates: the half plane, with the half column kx = 0, ky > 0.
std::vector<std::size_t> independent_modes() {
    std::vector<std::size_t> result;
    for (std::size_t m = 1; m < numerics::modes(grid); ++m) {
        const std::size_t column = m % numerics::columns(grid), row = m / numerics::columns(grid);
        if (numerics::is_kept(grid, 1, column, row) && (column > 0 || 2 * row < static_cast<std::size_t>(grid.ny)))
            result.push_back(m);
    }
    return result;
}

Whitened whitened(const numerics::System& system, const numerics::Spectra& state, std::size_t m) {
    const numerics::Wavevector q = numerics::wavevector(grid, m % numerics::columns(grid), m / numerics::columns(grid));
    const double length = std::hypot(q.x, q.y);
    const numerics::IsotropicBlocks rates = system.linear(length), noise = system.noise(length);
    const auto along = root(numerics::stationary_covariance(rates.along, noise.along));
    const double across = std::sqrt(numerics::stationary_covariance(rates.across, noise.across)(0, 0));
    const Complex i(0.0, 1.0), sigma = state[0][m], x = state[1][m], y = state[2][m];
    const Complex p_along = i * (q.x * x + q.y * y) / length, p_across = i * (q.x * y - q.y * x) / length;
    const double scale = std::sqrt(numerics::area(grid));
    Whitened result;
    result.z[0] = scale * sigma / along[0];
    result.z[1] = (scale * p_along - along[1] * result.z[0]) / along[2];
    result.z[2] = scale * p_across / across;
    return result;
}

void add(const numerics::System& system, const numerics::Spectra& state, const std::vector<std::size_t>& modes,
         Tally& tally) {
    const Complex i(0.0, 1.0);
    tally.of_mode.resize(modes.size());
    for (std::size_t k = 0; k < modes.size(); ++k) {
        const std::array<Complex, 3> z = whitened(system, state, modes[k]).z;
        std::size_t place = 0;
        for (const Complex value : z) {
            // Real and imaginary part have half of the variance each: twice the square is a chi-square of two degrees.
            tally.of_mode[k][place++] += 2.0 * std::norm(value);
            tally.whole += 2.0 * std::norm(value);
        }
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = a + 1; b < 3; ++b) {
                tally.of_mode[k][place++] += std::norm(z[a] + z[b]);
                tally.of_mode[k][place++] += std::norm(z[a] + i * z[b]);
            }
    }
    // The mean order: two real numbers of variance Delta/(2 a)/area each.
    const double variance = model.noise.order / (2.0 * model.relaxation.rate) / numerics::area(grid);
    for (const int c : {1, 2}) tally.mean_order += std::norm(state[c][0]) / variance;
    ++tally.realisations;
}

struct Verdict {
    double least = 1.0;  ///< least probability of all modes and pairs, times their number (Bonferroni)
    double whole = 1.0;  ///< probability of the whole set
    double mean_order = 1.0;
};

Verdict verdict(const Tally& tally) {
    Verdict result;
    const double degrees = 2.0 * tally.realisations;
    for (const auto& mode : tally.of_mode)
        for (const double squares : mode)
            result.least =
                std::min(result.least, two_sided(squares, degrees) * 9.0 * static_cast<double>(tally.of_mode.size()));
    result.whole = two_sided(tally.whole, degrees * 3.0 * static_cast<double>(tally.of_mode.size()));
    result.mean_order = two_sided(tally.mean_order, degrees);
    return result;
}

constexpr int realisations = 1500, steps = 4;
constexpr std::uint64_t seed = 20141021;  // fixed before the first run

/// Independent realisations from the stationary law, each some steps on.
template <class MakeStepper>
Tally sampled(const numerics::System& system, MakeStepper make_stepper) {
    const std::vector<std::size_t> modes = independent_modes();
    Tally tally;
    numerics::Stepper stepper = make_stepper();
    numerics::Spectra state(grid, 3);
    for (int r = 0; r < realisations; ++r) {
        numerics::draw_stationary(system,
                                  {.seed = seed + static_cast<std::uint64_t>(r), .stream = Stream::stationary_state},
                                  state);
        state[0][0] = 1.0;
        for (int n = 0; n < steps; ++n)
            stepper.step(n * stepper.dt(), static_cast<std::uint64_t>(r * steps + n), state);
        EXPECT_EQ(state[0][0], Complex(1.0)) << "the mean density is conserved to the last bit";
        add(system, state, modes, tally);
    }
    return tally;
}

TEST(StationarySpectrum, of_the_noisy_linear_model_is_the_lyapunov_solution_at_any_step) {
    Threads threads(1);
    const numerics::System system = linear_system(model, grid);
    for (const double dt_rate : {0.1, 1.0, 10.0}) {
        const double dt = dt_rate / fastest_rate(system);
        const Verdict found = verdict(sampled(system, [&] {
            return numerics::Stepper(system, numerics::stepper_table("etdrk2"), dt, seed, threads);
        }));
        EXPECT_GT(found.least, 1e-3) << "some mode or pair, dt|s|max = " << dt_rate;
        EXPECT_GT(found.whole, 1e-3) << "the whole set, dt|s|max = " << dt_rate;
        EXPECT_GT(found.mean_order, 1e-3) << "q = 0, dt|s|max = " << dt_rate;
    }
}

// A method that knows the linear part exactly but holds the noise still over a step has (2/z) tanh(z/2) of the variance,
// z = rate dt.  The test must see that.  (At dt|s|max = 0.1 the fastest mode lacks 8 parts in 10^4, which this many
// realisations cannot tell.)
TEST(StationarySpectrum, of_noise_frozen_over_the_step_fails_the_same_test) {
    Threads threads(1);
    Model plain = model;
    plain.noise.rods = 0.0;
    const numerics::System exact = linear_system(plain, grid);
    const numerics::Transform transform(grid, 1, threads);
    for (const double dt_rate : {1.0, 10.0}) {
        const double dt = dt_rate / fastest_rate(exact);
        numerics::System frozen = exact;
        frozen.noise = {};
        std::uint64_t drawn = 0;
        frozen.nonlinear = [&](double, const numerics::Spectra&, numerics::Spectra& rate) {
            numerics::Fields force(grid, 3);
            fill_normal({.seed = seed, .stream = Stream::test, .step = drawn++}, 0, 1, force.values);
            const double strength = std::sqrt(plain.noise.order * static_cast<double>(numerics::points(grid)) /
                                              (numerics::area(grid) * dt));
            for (std::size_t i = 0; i < force.size; ++i) {
                force[0][i] = 0.0;
                force[1][i] *= strength;
                force[2][i] *= strength;
            }
            transform.forward(force, rate);
        };
        const Verdict found = verdict(sampled(exact, [&] {
            return numerics::Stepper(frozen, numerics::stepper_table("exponential-euler"), dt, seed, threads);
        }));
        // At 1 the fastest mode lacks 8 %: three deviations of its own, which the whole set sees and Bonferroni may not.
        EXPECT_LT(std::min(found.whole, found.least), 1e-3) << "dt|s|max = " << dt_rate;
        if (dt_rate == 10.0) {
            EXPECT_LT(std::max(found.whole, found.least), 1e-3);
        }
    }
}

}  // namespace
}  // namespace drover::physics
