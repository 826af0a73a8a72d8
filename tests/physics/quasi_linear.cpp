// The generalised quasi-linear approximation against what it must keep: exact waves, invariants, the full model.
#include <gtest/gtest.h>

#include "physics/rod_bead_model.hpp"
#include "solver_support.hpp"
#include "text_terms.hpp"

namespace drover::physics::quasi_linear_tests {

namespace {
using numerics::Complex;
using numerics::Spectra;

const numerics::Grid line{.nx = 64, .ny = 1, .lx = 20.0, .ly = 20.0};
const double first = 2.0 * std::numbers::pi / line.lx;  // |q| of the longest wave

/// The rate where waves up to this |q| are long; without it that of the full model.
Spectra rate_of(const Model& model, const numerics::Grid& grid, const Spectra& state, double long_waves = INFINITY) {
    Threads threads(1);
    model::Integrated what = integrated(model, {});
    what.long_waves = long_waves;
    return numerics::WholeRate(model::system_of(what, grid, threads))(0.3, state);
}

/// A polar order without rods as a field.
Model order_alone() { return {.fields = {.rod_density = false}, .relaxation = {.rate = 0.0}}; }
}  // namespace

TEST(QuasiLinear, with_a_cutoff_beyond_the_grid_gives_the_bytes_of_the_full_model) {
    const Model model = full_model();
    const numerics::Grid grid{.nx = 16, .ny = 16, .lx = 20.0, .ly = 20.0};
    const Spectra state = waves(physics::form(model), model.uniform, grid, 0.2);
    EXPECT_EQ(rate_of(model, grid, state, 100.0).values, rate_of(model, grid, state).values);
}

TEST(QuasiLinear, with_only_the_mean_as_long_wave_keeps_of_a_cubic_what_involves_the_mean) {
    // -b |p|^2 p of p = M + A cos(qx): the mean feels M^3 + 3 M A^2/2, the wave 3 M^2 A and not A^3 or harmonics.
    Model model = order_alone();
    model.relaxation.saturation = 0.7;
    const double mean = 0.8, wave = 0.5;
    Spectra state(line, 2);
    state[0][0] = mean;
    state[0][3] = 0.5 * wave;
    const Spectra rate = rate_of(model, line, state, 0.0);
    EXPECT_NEAR(rate[0][0].real(), -0.7 * (mean * mean * mean + 1.5 * mean * wave * wave), 1e-14);
    EXPECT_NEAR(rate[0][3].real(), -0.7 * 3.0 * mean * mean * 0.5 * wave, 1e-14);
    EXPECT_NEAR(std::abs(rate[0][6]), 0.0, 1e-14);
    EXPECT_GT(std::abs(rate_of(model, line, state)[0][6]), 0.05);
}

TEST(QuasiLinear, conserves_the_square_that_self_advection_conserves_for_any_cutoff) {
    // -w p d_x p conserves the integral of p^2; so do the triads (l, l, l) and (l, h, h) by themselves.  It is the last
    // digits of rates of order one that remain.
    Model model = order_alone();
    model.advection.strength = 1.3;
    Spectra state(line, 2);
    for (int m = 0; m < 18; ++m)
        state[0][static_cast<std::size_t>(m)] = std::polar(1.0 / (1.0 + 0.2 * m), m == 0 ? 0.0 : 1.7 * m * m);
    const Spectra full = rate_of(model, line, state);
    for (const int longest : {0, 2, 7}) {
        const Spectra rate = rate_of(model, line, state, (longest + 0.5) * first);
        double power = 0.0, size = 0.0;
        for (std::size_t m = 0; m < state.size; ++m) {
            power += (m == 0 ? 1.0 : 2.0) * (std::conj(state[0][m]) * rate[0][m]).real();
            size += std::abs(state[0][m] * rate[0][m]);
        }
        EXPECT_NEAR(power, 0.0, 1e-13 * size) << longest;
        EXPECT_GT(distance(rate, full), 0.1) << "an approximation that leaves nothing out";
    }
}

TEST(QuasiLinear, leaves_what_acts_on_short_waves_from_outside) {
    Model model = order_alone();
    model.text_terms = {text_term("order", {"0.3 sin(2*pi*x/5) (1 + order_x)", "0"})};
    Spectra state(line, 2);
    state[0][0] = 0.5;
    EXPECT_LT(distance(rate_of(model, line, state, 0.0), rate_of(model, line, state)), 1e-15);
    EXPECT_GT(std::abs(rate_of(model, line, state)[0][4]), 0.1);
}

TEST(QuasiLinear, converges_to_the_full_model_with_the_cutoff) {
    const Model model = full_model();
    const numerics::Grid grid{.nx = 32, .ny = 32, .lx = 20.0, .ly = 20.0};
    Spectra state = waves(physics::form(model), model.uniform, grid, 0.3);
    const Spectra full = rate_of(model, grid, state);
    const auto error = [&](double above) { return distance(rate_of(model, grid, state, above), full); };
    // The state has waves of |q| = 1 and sqrt(2) in units of the first: beyond them nothing is short.
    EXPECT_GT(error(0.0), 1e-3);
    EXPECT_LT(error(3.0 * first), 0.5 * error(0.0));
}

}  // namespace drover::physics::quasi_linear_tests
