// tests/model/noise_drift.cpp: noise that multiplies fields, in the sense of Stratonovich.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "drover/base/error.hpp"
#include "drover/model/evolution.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "numerics/steppers/kept_modes.hpp"
#include "numerics/steppers/linear_operator.hpp"

namespace drover::model::noise_drift_tests {
namespace {

using numerics::Spectra;

const numerics::Grid grid{.nx = 24, .ny = 24, .lx = 10.0, .ly = 10.0};

/// Moments of an isotropic set of modes; none is a multiple of another.
double moment(int x, int y) {
    if (x + y == 0) return 1.7;
    if (x + y == 2) return 0.9;
    return x == y ? 0.3 : 0.8;
}

Field field(const std::string& symbol, int spin, const std::string& equation, const std::string& mass = "") {
    return {.name = symbol,
            .symbol = symbol,
            .spin = spin,
            .mass = {mass, {}},
            .equation = {equation, {}},
            .reference = spin == 0 ? 1.5 : 0.0};
}

struct Case {
    const char* name;
    std::vector<Field> fields;
    std::vector<std::string> drifts;  ///< derived by hand: of the rate of each field
};

Model model_of(const std::vector<Field>& fields) {
    return {.fields = fields,
            .definitions = {},
            .coefficients = {{"M", moment(0, 0)}, {"M2", moment(2, 0)}, {"M4", moment(4, 0) + moment(2, 2)}},
            .noises = {{.symbol = "xi"}, {.symbol = "eta", .odd = true}, {.symbol = "z", .spin = 1}}};
}

Spectra rates(const Equations& equations) {
    Threads threads(1);
    const numerics::System system = equations.system(grid, threads, 4);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const int count = static_cast<int>(equations.state_components().size());
    Spectra state(grid, count), rate(grid, count);
    const std::size_t width = numerics::columns(grid);
    for (int c = 0; c < count; ++c)
        for (const std::size_t mode : {std::size_t{0}, std::size_t{1}, width + 1, width * 23 + 1})
            state[c][mode] = 0.1 * numerics::Complex(normal(random), mode == 0 ? 0.0 : normal(random));
    for (int c = 0; c < count; ++c) state[c][0] += 1.5;  // densities above 0
    if (system.nonlinear) system.nonlinear(0.0, state, rate);
    numerics::LinearOperator(system).add(state, rate);
    return rate;
}

std::vector<Case> cases() {
    return {
        // g(u) xi: M g g'/2.
        {"a scalar", {field("u", 0, "-u + u^2 xi")}, {"M u^3"}},
        {"a square root", {field("u", 0, "-u + sqrt(u) xi")}, {"M/4"}},
        // perp(p) eta turns p at random: its mean decays.
        {"a rotation", {field("p", 1, "-p + perp(p) eta")}, {"-(M/2) p"}},
        // (p.z): the change of p_i is (p.p) z_i + ..., for p_i (p.z): p_j z_j z_i p_k ... by components:
        // V_i = p_i p_j z_j, dV_i = V_i p_j z_j + p_i V_j z_j, means p_i p_j p_j + p_i p_j p_j.
        {"a vector noise", {field("p", 1, "-p + (p.z) p")}, {"M (p.p) p"}},
        // -z.grad u, a flow that is white in time: M lap u/2, as <z_j d_j z_i> is 0.
        {"a random flow", {field("u", 0, "-u - z.grad u")}, {"(M/2) lap u"}},
        // div(g z): div(g' grad g) M/2.
        {"a flux", {field("u", 0, "lap u + div(sqrt(u) z)")}, {"(M/8) div(grad u/u)"}},
        // u lap xi: the mean square of lap xi is the sum of q^4.
        {"derivatives of noise", {field("u", 0, "-u + u lap xi")}, {"M4 u"}},
        // lap(u xi): lap of (lap u xi + 2 grad u.grad xi + u lap xi) xi, of which the last has -q^2.
        {"outer derivatives", {field("u", 0, "-u + lap(u xi)")}, {"lap(M lap u/2 - M2 u)"}},
        {"fields that share a noise",
         {field("a", 0, "-a + b xi"), field("b", 0, "-b + a^2 xi")},
         {"(M/2) a^2", "M a b"}},
        {"additive noise too", {field("a", 0, "-a + xi"), field("b", 0, "-b + a b xi")}, {"0 a", "(M/2) (b + a^2 b)"}},
        {"a constant mass", {field("u", 0, "-u + u xi", "2")}, {"(M/8) u"}},
        {"a mass that is a factor", {field("r", 0, "-r"), field("u", 0, "-u + r u xi", "r")}, {"0 r", "(M/2) u"}},
    };
}

TEST(NoiseDrift, of_stratonovich_is_the_one_derived_by_hand) {
    for (const Case& one : cases()) {
        SCOPED_TRACE(one.name);
        Model of_stratonovich = model_of(one.fields), of_ito = model_of(one.fields);
        of_stratonovich.noise_moment = moment;
        for (std::size_t n = 0; n < one.fields.size(); ++n) {
            Field& changed = of_ito.fields[n];
            const std::string factor = changed.mass.text.empty() ? "" : changed.mass.text + " ";
            changed.equation.text += " + " + factor + "(" + one.drifts[n] + ")";
        }
        const Equations with(of_stratonovich), by_hand(of_ito), without(model_of(one.fields));
        const Spectra expected = rates(by_hand), found = rates(with), plain = rates(without);
        double size = 0.0, difference = 0.0, drift = 0.0;
        for (std::size_t k = 0; k < found.values.size(); ++k) {
            size = std::max(size, std::abs(expected.values[k]));
            difference = std::max(difference, std::abs(found.values[k] - expected.values[k]));
            drift = std::max(drift, std::abs(found.values[k] - plain.values[k]));
        }
        EXPECT_LT(difference, 1e-12 * size);  // rounding of derivatives and transforms
        EXPECT_GT(drift, 0.01 * size);
        const UniformState about(static_cast<std::size_t>(with.components()), 1.3);
        EXPECT_LT((with.uniform_rates(about) - by_hand.uniform_rates(about)).norm(), 1e-13);
        const numerics::Wavevector q{0.7, -0.4};
        EXPECT_LT((with.symbol(about, q) - by_hand.symbol(about, q)).norm(), 1e-13);
        EXPECT_EQ((with.noise(about, q) - by_hand.noise(about, q)).norm(), 0.0);
    }
}

TEST(NoiseDrift, moments_are_sums_over_the_modes_that_the_grid_keeps) {
    // |k| < 24/4 on each axis.
    double count = 0.0, square = 0.0;
    const double first = 2.0 * std::numbers::pi / 10.0;
    for (int i = -5; i <= 5; ++i)
        for (int j = -5; j <= 5; ++j) count += 1.0, square += i * i * first * first;
    EXPECT_DOUBLE_EQ(noise_moment(grid, 3, 0, 0), count / 100.0);
    EXPECT_NEAR(noise_moment(grid, 3, 2, 0), square / 100.0, 1e-12 * square);
    EXPECT_NEAR(noise_moment(grid, 3, 0, 2), square / 100.0, 1e-12 * square);
}

TEST(NoiseDriftLong, keeps_the_size_of_a_vector_that_noise_turns) {
    // One mode: the vector turns as a whole, d_t p = perp(p) eta, by an angle of variance 2t.  An Euler step changes
    // |p|^2 by the square of its angle less the mean: by 0.06 over 1000 steps of variance 0.002; in the sense of Ito
    // |p|^2 grows by e^2.
    const numerics::Grid cell{.nx = 4, .ny = 4, .lx = 1.0, .ly = 1.0};
    Model turning = model_of({field("p", 1, "s perp(p) eta")});
    turning.coefficients["s"] = std::sqrt(2.0);
    const int degree = 4;
    turning.noise_moment = [&](int x, int y) { return noise_moment(cell, degree, x, y); };
    ASSERT_EQ(turning.noise_moment(0, 0), 1.0);
    Threads threads(1);
    double cosine = 0.0;
    constexpr int runs = 400;
    for (int run = 0; run < runs; ++run) {
        const numerics::System system = Equations(turning).system(cell, threads, degree);
        numerics::Stepper stepper(system, numerics::stepper_table("etdrk2"), 1e-3, static_cast<std::uint64_t>(run),
                                  threads);
        Spectra state(cell, 2);
        state[0][0] = 1.0;
        for (int step = 0; step < 1000; ++step) stepper.step(1e-3 * step, static_cast<std::uint64_t>(step), state);
        EXPECT_NEAR(std::hypot(state[0][0].real(), state[1][0].real()), 1.0, 0.15) << run;
        cosine += state[0][0].real() / runs;
    }
    EXPECT_NEAR(cosine, std::exp(-1.0), 4.0 * std::sqrt(0.5 / runs));  // the variance of a cosine is below 1/2
}

TEST(NoiseDrift, is_refused_where_it_is_not_known) {
    const auto message = [](Model model) {
        model.noise_moment = moment;
        try {
            const Equations equations(model);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    Model flow = model_of({field("v", 1, "-v + (v.v) z")});
    flow.fields[0].solenoidal = true;
    EXPECT_NE(message(flow).find("v is solenoidal; expected noise of other fields"), std::string::npos);
    EXPECT_NE(message(model_of({field("r", 0, "-r"), field("u", 0, "-u + u xi", "r")})).find("a mass that varies"),
              std::string::npos);
    Model held = model_of({field("u", 0, "-u + w xi"), field("w", 0, "u - w + lap w")});
    held.fields[1].left = LeftSide::balance;
    EXPECT_NE(message(held).find("depends on a field in balance"), std::string::npos);
}

}  // namespace
}  // namespace drover::model::noise_drift_tests
