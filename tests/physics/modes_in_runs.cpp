// tests/physics/modes_in_runs.cpp: small waves in runs of the whole model grow, decay and travel at the rates of
// linear theory.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "evolution.hpp"
#include "modes.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::modes_in_runs_tests {
namespace {

using numerics::Complex;
constexpr double pi = std::numbers::pi;

// A wave of 1e-6 beside fields of order one leaves 1e-12 to the next order.  Rounding over a thousand steps is
// 1e-16 sqrt(1000)/1e-6 = 3e-9 of the logarithm of its amplitude.  The method errs by (rate dt)^4/120 of the largest
// rate that is not in its exact linear part, 2 b p0^2 = 0.6 /s with dt = 0.25 s: 4e-6, and 2e-5 of a smaller rate
// beside it.
constexpr double amplitude = 1e-6, tolerance = 1e-4;

struct Mode {
    Complex expected, found;  ///< rates [1/s]
    double bend = 0.0;        ///< largest distance of the logarithm of the amplitude from a straight line
};

/// Slope of a line through points, by least squares, and the largest distance from it.
std::pair<Complex, double> line(const std::vector<double>& t, const std::vector<Complex>& y) {
    const double n = static_cast<double>(t.size());
    double mean_t = 0.0, square = 0.0, far = 0.0;
    Complex mean_y = 0.0, product = 0.0;
    for (std::size_t i = 0; i < t.size(); ++i) mean_t += t[i] / n, mean_y += y[i] / n;
    for (std::size_t i = 0; i < t.size(); ++i) {
        square += (t[i] - mean_t) * (t[i] - mean_t);
        product += (t[i] - mean_t) * (y[i] - mean_y);
    }
    const Complex slope = product / square;
    for (std::size_t i = 0; i < t.size(); ++i) far = std::max(far, std::abs(y[i] - mean_y - slope * (t[i] - mean_t)));
    return {slope, far};
}

/// A wave on a uniform state, on the grid of a run.
struct Wave {
    Model model;
    numerics::Grid grid;
    UniformPoint about;
    int kx, ky;  ///< mode numbers, kx >= 0

    std::size_t row() const { return static_cast<std::size_t>((ky + grid.ny) % grid.ny); }
    std::size_t place() const { return row() * numerics::columns(grid) + static_cast<std::size_t>(kx); }
    /// Of its conjugate, where that is stored too.
    std::size_t partner() const { return static_cast<std::size_t>((grid.ny - ky) % grid.ny) * numerics::columns(grid); }
    WaveModes modes() const {
        const Equations equations(model);
        return WaveModes(
            rate_matrix(equations, about, numerics::wavevector(grid, static_cast<std::size_t>(kx), row())));
    }
};

/// WaveModes of one wave, all of them put on the uniform state and each measured by its left eigenvector in one run of
/// `steps`, a multiple of 20.
std::vector<Mode> measured(const Wave& wave, const std::vector<int>& which, double dt, int steps) {
    Evolution run(wave.model, wave.grid);
    const WaveModes modes = wave.modes();
    const numerics::Spectra rest = uniform_state(run.form, wave.grid, wave.about);
    numerics::Spectra state = rest;
    for (int c = 0; c < state.count(); ++c) {
        for (const int k : which) state[c][wave.place()] += amplitude * modes.right(c, k);
        if (wave.kx == 0) state[c][wave.partner()] = std::conj(state[c][wave.place()]);
    }
    std::vector<double> times;
    std::vector<std::vector<Complex>> logarithms(which.size());
    const auto look = [&](double t) {
        Eigen::VectorXcd deviation(state.count());
        for (int c = 0; c < state.count(); ++c) deviation(c) = state[c][wave.place()] - rest[c][wave.place()];
        const Eigen::VectorXcd amplitudes = modes.left * deviation;
        times.push_back(t);
        for (std::size_t k = 0; k < which.size(); ++k) {
            Complex value = std::log(amplitudes(which[k]));
            if (!logarithms[k].empty()) {  // the branch nearest to the last
                const double turned = value.imag() - logarithms[k].back().imag();
                value.imag(value.imag() - 2.0 * pi * std::round(turned / (2.0 * pi)));
            }
            logarithms[k].push_back(value);
        }
    };
    numerics::Stepper by = run.stepper("etdrk4", dt);
    look(0.0);
    for (int i = 0; i < steps; ++i) {
        by.step(i * dt, static_cast<std::uint64_t>(i), state);
        if ((i + 1) % (steps / 20) == 0) look((i + 1) * dt);
    }
    if (wave.kx != 0 || wave.ky != 0) {
        for (int c = 0; c < state.count(); ++c)
            // Below the waves the state stands still, but for amplitude^2 times e^2 of growth, with room.
            EXPECT_LT(std::abs(state[c][0] - rest[c][0]), 1e-10) << "component " << c;
    }
    std::vector<Mode> found;
    for (std::size_t k = 0; k < which.size(); ++k) {
        const auto [slope, bend] = line(times, logarithms[k]);
        found.push_back({.expected = modes.rates(which[k]), .found = slope, .bend = bend});
    }
    return found;
}

/// Growth and frequency each to the tolerance; one that is zero by symmetry to the tolerance times the other.
void expect_rate(const Mode& mode, const std::string& what) {
    const double size = std::abs(mode.expected);
    const auto bound = [&](double part) { return tolerance * (std::abs(part) > 1e-9 * size ? std::abs(part) : size); };
    EXPECT_NEAR(mode.found.real(), mode.expected.real(), bound(mode.expected.real())) << what;
    EXPECT_NEAR(mode.found.imag(), mode.expected.imag(), bound(mode.expected.imag())) << what;
    EXPECT_LT(mode.bend, 1e-5) << what
                               << ": one exponential, not several; 3e-9 and the method's 2e-5 of a growth by e^0.1";
}

/// Beads and rods, every coefficient of order one and constant.
Model two_components(double relaxation) {
    return {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
            .uniform = {.rod_density = 0.8, .bead_density = 1.2},
            .current = {.speed = 0.9},
            .inertia = {.bead_mass = 1.3},
            .drag = {.coefficient = 2.0},
            .viscosity = {.shear = 0.3, .bulk = 0.1},
            .driving = {.strength = 1.5},
            .stiffness = {.beads = 1.1, .rods = 0.4},
            .relaxation = {.rate = relaxation, .saturation = 0.8},
            .elasticity = {.stiffness = 0.5, .splay = 0.2},
            .weathercock = {.strength = 0.8},
            .advection = {.strength = 0.6},
            .pressure = {.beads = 0.3, .rods = 0.6}};
}
constexpr double carried = 0.8 * 1.5 / 2.0;  // lambda alpha/Gamma
constexpr double mass = 1.3 * 1.2;           // m rho
constexpr double chi = 1.0 + mass * carried / 2.0;

// --- the onset of order: across q, (m rho s + Gamma + eta q^2)(s + a + K3 q^2) = lambda alpha

/// The larger root.
double growth_across(double relaxation, double q) {
    const double g = (2.0 + 0.3 * q * q) / mass, h = relaxation + 0.5 * q * q;
    return 0.5 * (-(g + h) + std::sqrt((g - h) * (g - h) + 4.0 * 0.8 * 1.5 / mass));
}

TEST(OnsetOfOrder, grows_at_the_root_of_its_quadratic_in_a_uniform_state_and_in_waves) {
    const double abar = -0.02;
    for (const int ky : {0, 1}) {
        const Wave wave{.model = two_components(carried + abar),
                        .grid = {8, 16, 45.0, 55.0},
                        .about = {.bead_density = 1.2, .rod_density = 0.8},
                        .kx = 0,
                        .ky = ky};
        const double growth = growth_across(carried + abar, 2.0 * pi * ky / wave.grid.ly);
        ASSERT_GT(growth, 0.0);
        const Mode mode = measured(wave, {wave.modes().nearest(growth)}, 1.0, 100)[0];
        expect_rate(mode, text("ky = {}", ky));
        EXPECT_NEAR(mode.found.real() / growth, 1.0, tolerance) << "ky = " << ky;
    }
}

TEST(OnsetOfOrder, is_slowed_by_the_inertia_of_the_beads_to_minus_abar_over_chi) {
    for (const double abar : {-1e-3, 1e-3}) {
        const Wave wave{.model = two_components(carried + abar),
                        .grid = {8, 8, 45.0, 55.0},
                        .about = {.bead_density = 1.2, .rod_density = 0.8},
                        .kx = 0,
                        .ky = 0};
        const Mode mode = measured(wave, {wave.modes().nearest(-abar / chi)}, 10.0, 100)[0];
        // The quadratic's own next order: s^2 m rho/(Gamma chi) beside abar/chi, 1e-3 * 1.56/(2 * 1.47^2) = 4e-4.
        EXPECT_NEAR(mode.found.real() / (-abar / chi), 1.0, 1e-3) << "abar = " << abar;
        expect_rate(mode, text("abar = {}", abar));
    }
}

// --- waves in a flock

/// Coefficients of the slow modes of long waves in the flock of two_components.
struct LongWaves {
    double pressure;         ///< A
    double order, velocity;  ///< p0, v0
    double abar = pressure + 0.8 * 1.1 / 2.0, bbar = 0.6 + 0.8 * 0.4 / 2.0;
    double c0 = 0.9 * bbar + 1.2 * 1.5 / 2.0 * abar;

    /// How far a speed u [mm/s] is from a root of u (u - v0 c)(u - v1 c) = (s^2/chi)(C0 u - speed Bbar v0 c), by one
    /// step of Newton's method.
    double distance(Complex u, double angle) const {
        const double c = std::cos(angle), s = std::sin(angle), v0 = velocity * c, v1 = 0.6 * order / chi * c;
        const Complex cubic = u * (u - v0) * (u - v1) - s * s / chi * (c0 * u - 0.9 * bbar * v0);
        return std::abs(cubic / ((u - v0) * (u - v1) + u * (2.0 * u - v0 - v1) - s * s / chi * c0));
    }
};

/// The wave (2, 1) of a grid with the order turned to an angle from it.
Wave wave_at(double angle, const Model& model, const numerics::Grid& grid) {
    const numerics::Wavevector q = numerics::wavevector(grid, 2, 1);
    const UniformPoint about = flock(Equations(model), std::atan2(q.y, q.x) - angle);
    return {.model = model, .grid = grid, .about = about, .kx = 2, .ky = 1};
}
LongWaves long_waves(const Wave& wave) {
    return {.pressure = wave.model.pressure.beads,
            .order = wave.about.order.norm(),
            .velocity = wave.about.velocity.norm()};
}
/// s = -i u q.
Complex speed(const Mode& mode, const Wave& wave) {
    const numerics::Wavevector q = numerics::wavevector(wave.grid, 2, 1);
    return Complex(0.0, 1.0) * mode.found / std::hypot(q.x, q.y);
}
constexpr numerics::Grid large{16, 16, 2400.0, 2700.0};  // q = 0.0057 /mm

TEST(SoundInAFlock, travels_and_dies_at_the_rates_of_linear_theory_at_four_angles_to_the_order) {
    for (const double angle : {0.0, 0.5, 1.1, 0.5 * pi})
        for (const numerics::Grid& grid : {large, numerics::Grid{16, 16, 100.0, 120.0}}) {
            const Wave wave = wave_at(angle, two_components(carried - 0.3), grid);
            const LongWaves theory = long_waves(wave);
            for (const Mode& mode : measured(wave, {0, 1, 2}, 0.25, grid.lx == large.lx ? 800 : 80)) {
                expect_rate(mode, text("angle {}, cell of {} mm", angle, grid.lx));
                // The next order in q: (q l)^2, l some millimetres: 9e-5 mm/s at most.
                if (grid.lx == large.lx) {
                    EXPECT_LT(theory.distance(speed(mode, wave).real(), angle), 3e-4) << "angle " << angle;
                }
            }
        }
}

// Abar = A + lambda E/Gamma < 0: order turns to where beads are many.  The cubic then has two complex roots at oblique
// angles.
TEST(FlockThatSeeksBeads, grows_in_oblique_waves_and_in_none_along_or_across_its_order) {
    Model model = two_components(carried - 0.3);
    model.pressure.beads = -0.6;  // Abar = -0.16
    for (const numerics::Grid& grid : {large, numerics::Grid{16, 16, 140.0, 150.0}}) {
        std::vector<double> growth;
        for (int i = 0; i <= 6; ++i) {  // steps of 15 degrees
            const double angle = i * pi / 12.0;
            const Wave wave = wave_at(angle, model, grid);
            const Mode mode =
                measured(wave, {wave.modes().fastest_growing()}, 0.25, grid.lx == large.lx ? 800 : 200)[0];
            expect_rate(mode, text("{} degrees, cell of {} mm", 15 * i, grid.lx));
            growth.push_back(mode.found.real());
            // u = speed + i growth/q, with growth/q = 0.12 mm/s at 30 degrees.  The cubic leaves out the damping:
            // gamma q, gamma < 1 mm^2/s.
            if (grid.lx == large.lx) {
                EXPECT_LT(long_waves(wave).distance(speed(mode, wave), angle), 0.006) << 15 * i << " degrees";
            }
        }
        EXPECT_LT(growth.front(), 0.0) << "along the order";
        EXPECT_LT(growth.back(), 0.0) << "across it";
        EXPECT_GT(growth[2], 0.0) << "at 30 degrees";
        EXPECT_GT(growth[3], 0.0) << "at 45 degrees";
    }
}

// --- bands

/// Rods alone whose order grows where they are dense: a = mu (sigma_c - sigma).
struct Banding {
    double mu = 0.9, critical = 1.1, saturation = 0.8, pressure = 1.2, advection = 0.7, stiffness = 0.5, splay = 0.3;
    double density = 1.15;

    Model model() const {
        return {.uniform = {.rod_density = density},
                .current = {.speed = 1.0},
                .relaxation = {.rate = mu * critical, .rate_terms = {text("{} sigma", -mu)}, .saturation = saturation},
                .elasticity = {.stiffness = stiffness, .splay = splay},
                .advection = {.strength = advection},
                .pressure = {.rods = pressure}};
    }
    /// K q_c^2 = nu ([-w p0 p0' + sqrt(w^2 p0^2 p0'^2 + 4 B p0'^2)]/(2 B) - 1), nu = 2 b p0^2, p0' = mu/(2 b p0).
    double neutral() const {
        const double p0 = std::sqrt(mu * (density - critical) / saturation), slope = mu / (2.0 * saturation * p0);
        const double turn = advection * p0 * slope;
        const double root = (-turn + std::sqrt(turn * turn + 4.0 * pressure * slope * slope)) / (2.0 * pressure);
        return std::sqrt(2.0 * saturation * p0 * p0 * (root - 1.0) / (stiffness + splay));
    }
    /// The mode of a band, its wave along the order, as a run shows it.
    Mode mode(double q) const {
        const Wave wave{.model = model(),
                        .grid = {16, 8, 2.0 * pi / q, 10.0},
                        .about = flock(Equations(model()), 0.0),
                        .kx = 1,
                        .ky = 0};
        return measured(wave, {wave.modes().fastest_growing()}, 0.05, 200)[0];
    }
};

TEST(Bands, grow_in_waves_longer_than_the_neutral_one_and_die_in_shorter_ones) {
    const Banding rods;
    const double q = rods.neutral();
    const Mode longer = rods.mode(0.99 * q), shorter = rods.mode(1.01 * q);
    expect_rate(longer, "longer");
    expect_rate(shorter, "shorter");
    EXPECT_GT(longer.found.real(), 0.0);
    EXPECT_LT(shorter.found.real(), 0.0);
    // Where the growth that the runs show passes zero, by a straight line between two waves 1 % away: right to some
    // 0.01^2.
    const double rise = shorter.found.real() - longer.found.real();
    EXPECT_NEAR((0.99 * shorter.found.real() - 1.01 * longer.found.real()) / rise, 1.0, 2e-4);
}

}  // namespace
}  // namespace drover::physics::modes_in_runs_tests
