// tests/physics/long_waves.cpp: slow modes of uniform states against their closed forms, and against the eigenvalues
// they approach.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <numbers>

#include "flock_model.hpp"
#include "numerics/algebra/dense.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::long_waves_tests {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

/// The mode whose speed is nearest to one.
SlowMode mode_of_speed(const LongWaves& waves, double angle, double speed) {
    std::vector<SlowMode> modes = slow_modes(waves, angle);
    return *std::min_element(modes.begin(), modes.end(), [&](const SlowMode& a, const SlowMode& b) {
        return std::abs(a.speed - speed) < std::abs(b.speed - speed);
    });
}

LongWaves flock_waves(const Letters& letters) {
    const Equations equations(flock_model(letters));
    return long_waves(equations, flock_of(equations));
}

// u (u - v0 c)(u - v1 c) = (s^2/chi)(C0 u - Bbar v0 c): every entry of U has its own rounding, some 1e-16 of numbers
// of order one.
TEST(SlowModes, of_a_flock_have_the_speeds_of_the_cubic_at_every_angle) {
    for (const double w : {0.0, 0.35, -1.2}) {
        const Letters l{.w = w};
        const LongWaves waves = flock_waves(l);
        for (int n = 1; n < 36; ++n) {
            const double angle = 2.0 * pi * n / 36.0, c = std::cos(angle), s = std::sin(angle);
            const double v1 = l.w * l.p0() / l.chi();
            const std::vector<SlowMode> modes = slow_modes(waves, angle);
            ASSERT_EQ(modes.size(), 3u);
            for (const SlowMode& mode : modes) {
                const Complex u = mode.speed;
                EXPECT_LT(std::abs(u * (u - l.v0() * c) * (u - v1 * c) -
                                   s * s / l.chi() * (l.c0() * u - l.bbar() * l.v0() * c)),
                          1e-12);
            }
        }
    }
}

TEST(SlowModes, along_the_order_have_the_dampings_of_the_closed_forms) {
    const Letters l;
    const LongWaves waves = flock_waves(l);
    // Three different speeds: 0, v0, v1.
    const double v1 = l.w * l.p0() / l.chi();
    EXPECT_NEAR(mode_of_speed(waves, 0.0, 0.0).damping.real(), l.bbar() / l.nu(), 1e-12);
    EXPECT_NEAR(mode_of_speed(waves, 0.0, l.v0()).damping.real(),
                l.rho * (l.e + l.alpha * l.abar_beads() / l.nu()) / l.gamma, 1e-12);
    EXPECT_NEAR(mode_of_speed(waves, 0.0, l.v0()).speed.real(), l.v0(), 1e-12);
    const double order = (l.k3 + l.lambda * l.alpha * l.eta / (l.gamma * l.gamma)) / l.chi() +
                         l.lambda * l.alpha * std::pow(l.rho * l.w * l.p0(), 2) / std::pow(l.gamma * l.chi(), 3);
    EXPECT_NEAR(mode_of_speed(waves, 0.0, v1).damping.real(), order, 1e-12);
    EXPECT_NEAR(mode_of_speed(waves, 0.0, v1).speed.real(), v1, 1e-12);
}

TEST(SlowModes, across_the_order_are_sound_and_a_stationary_mode) {
    const Letters l;
    const LongWaves waves = flock_waves(l);
    const double sound = std::sqrt(l.c0() / l.chi());
    EXPECT_NEAR(mode_of_speed(waves, pi / 2.0, sound).speed.real(), sound, 1e-12);
    EXPECT_NEAR(mode_of_speed(waves, pi / 2.0, -sound).speed.real(), -sound, 1e-12);
    const SlowMode still = mode_of_speed(waves, pi / 2.0, 0.0);
    EXPECT_NEAR(std::abs(still.speed), 0.0, 1e-12);
    EXPECT_NEAR(still.damping.real(), l.rho * (l.e * l.bbar() - l.f * l.abar_beads()) / (l.gamma * l.c0()), 1e-12);
}

TEST(SlowModes, of_the_isotropic_state_diffuse_by_the_matrix_of_the_closed_form) {
    const Letters l = isotropic_letters();
    const Equations equations(flock_model(l));
    const LongWaves waves = long_waves(equations, isotropic_of(equations));
    const double abar = l.abar();
    Eigen::Matrix2d diffusion;
    diffusion << l.rho * (l.e + l.alpha * l.abar_beads() / abar) / l.gamma,
        l.rho * (l.f + l.alpha * l.bbar() / abar) / l.gamma, l.abar_beads() / abar, l.bbar() / abar;
    Eigen::Vector2d expected = numerics::dense_eigenvalues(Eigen::MatrixXd(diffusion)).real();
    std::sort(expected.begin(), expected.end());
    for (const double angle : {0.0, 0.7, 2.9}) {
        std::vector<SlowMode> modes = slow_modes(waves, angle);
        ASSERT_EQ(modes.size(), 2u);
        std::sort(modes.begin(), modes.end(),
                  [](const SlowMode& a, const SlowMode& b) { return a.damping.real() < b.damping.real(); });
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(modes[i].speed, 0.0);
            EXPECT_NEAR(modes[i].damping.real(), expected(static_cast<int>(i)), 1e-12);
        }
    }
}

/// Largest |s - (-i u q - gamma q^2)| of all slow modes at a wavevector.
double remainder(const Equations& equations, const StationaryState& about, const LongWaves& waves, double q,
                 double angle) {
    const Eigen::VectorXcd rates = mode_rates(equations, about.point, wavevector_from_order(about.point, q, angle));
    double largest = 0.0;
    for (const SlowMode& mode : slow_modes(waves, angle)) {
        const Complex s = Complex(0.0, -1.0) * mode.speed * q - mode.damping * q * q;
        largest = std::max(largest, (rates.array() - s).abs().minCoeff());
    }
    return largest;
}

struct Case {
    std::string name;
    Model model;
    int state;
    double power;
};

std::vector<Case> cases() {
    const Letters l;
    Model flock = flock_model(l), mean = flock, slaved = flock, dilute = flock, varying = flock, rods,
          isotropic = flock_model(isotropic_letters());
    mean.current.kind = "density-order";
    mean.inertia.bead_mass = 0.6;
    slaved.fields.bead_velocity = "slaved";
    dilute.fields.rod_density = false;
    dilute.current.speed = dilute.stiffness.rods = dilute.pressure.rods = 0.0;
    varying.relaxation.rate_terms = {"-0.1 sigma", "-0.05 rho"};
    varying.driving.strength_terms = {"0.1 rho sigma"};
    varying.drag.coefficient_terms = {"0.2 rho^2"};
    varying.weathercock.strength_terms = {"0.15 sigma"};
    varying.relaxation.saturation_terms = {"0.1 sigma"};
    varying.diffusion = {.beads = 0.05, .rods = 0.07};
    rods = {.uniform = {.rod_density = 0.9},
            .current = {.speed = 1.2},
            .relaxation = {.rate = 0.2, .rate_terms = {"-0.8 sigma"}, .saturation = 0.8},
            .elasticity = {.stiffness = 0.5, .splay = 0.2},
            .advection = {.strength = 0.4},
            .pressure = {.rods = 0.7}};
    // Odd orders of q are imaginary and even ones real in a flock: after q^2 comes q^3.  The isotropic state is even
    // in q: after q^2 comes q^4.
    return {{"flock", flock, 1, 3.0},
            {"order per rod", mean, 1, 3.0},
            {"slaved", slaved, 1, 3.0},
            {"dilute", dilute, 1, 3.0},
            {"coefficients by density", varying, 1, 3.0},
            {"rods only", rods, 1, 3.0},
            {"isotropic", isotropic, 0, 4.0}};
}

TEST(SlowModes, miss_the_eigenvalues_by_the_next_order_in_q) {
    for (const Case& one : cases()) {
        const Equations equations(one.model);
        const StationaryState about = stationary_states(equations).states.at(static_cast<std::size_t>(one.state));
        const LongWaves waves = long_waves(equations, about);
        ASSERT_EQ(waves.why_none, "") << one.name;
        for (const double angle : {0.0, 0.4, 1.1, pi / 2.0, 2.3}) {
            double last = 0.0;
            for (const double q : {0.01, 0.005, 0.0025}) {
                const double wrong = remainder(equations, about, waves, q, angle);
                // Rounding: 1e-15 of rates of order one; closed forms that leave nothing over stop there.
                if (last > 1e-12) {
                    EXPECT_NEAR(std::log2(last / wrong), one.power, 0.35) << one.name << " at " << angle;
                }
                last = wrong;
            }
            EXPECT_LT(last, 1e-4) << one.name << " at " << angle;
        }
    }
}

TEST(SlowModes, near_onset_do_not_depend_on_the_unit_of_density) {
    // J = u sigma p: sigma, its slope of a and B in another unit change nothing else.
    const auto modes_of = [](double s) {
        const Model model{.uniform = {.rod_density = 1.0 * s},
                          .current = {.speed = 1.0, .kind = "density-order"},
                          .relaxation = {.rate = 1.0 - 1e-4,
                                         .rate_terms = {text("{} sigma", -1.0 / s)},
                                         .saturation = 1.0},
                          .elasticity = {.stiffness = 1.0},
                          .pressure = {.rods = 1.0 / s}};
        const Equations e(model);
        return slow_modes(long_waves(e, flock_of(e)), 0.0);
    };
    const std::vector<SlowMode> plain = modes_of(1.0);
    for (const double s : {1e-6, 1e6}) {
        const std::vector<SlowMode> found = modes_of(s);
        ASSERT_EQ(found.size(), plain.size());
        for (std::size_t i = 0; i < plain.size(); ++i) {
            // abar = -1e-4 is a difference of numbers of order one: twelve digits are left, of which the root and the
            // square take some.
            EXPECT_NEAR(found[i].speed.real(), plain[i].speed.real(), 1e-9 * std::abs(plain.back().speed));
            EXPECT_NEAR(found[i].damping.real(), plain[i].damping.real(), 1e-9 * (1.0 + std::abs(plain[i].damping)));
        }
    }
}

TEST(SlowModes, of_beads_without_drag_are_sound) {
    // No drag, no driving: rho d_t v = -E grad rho; s = +- i sqrt(E) q - (eta + zeta) q^2/(2 rho), and -eta q^2/rho
    // across.
    Letters l{.gamma = 0.0, .alpha = 0.0, .f = 0.0};
    Model model = flock_model(l);
    model.pressure.beads = 0.0;
    model.weathercock.strength = 0.0;
    const Equations equations(model);
    const LongWaves waves = long_waves(equations, isotropic_of(equations));
    ASSERT_EQ(waves.why_none, "");
    const double sound = std::sqrt(l.e);
    const SlowMode mode = mode_of_speed(waves, 0.6, sound);
    EXPECT_NEAR(mode.speed.real(), sound, 1e-12);
    EXPECT_NEAR(mode.damping.real(), (l.eta + l.zeta) / (2.0 * l.rho), 1e-12);
    std::vector<double> still;
    for (const SlowMode& one : slow_modes(waves, 0.6))
        if (std::abs(one.speed) < 1e-9) still.push_back(one.damping.real());
    std::sort(still.begin(), still.end());
    ASSERT_EQ(still.size(), 2u);  // shear of the beads, diffusion of the rods
    std::vector<double> expected{l.eta / l.rho, l.pressure_b / l.a};
    std::sort(expected.begin(), expected.end());
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(still[i], expected[i], 1e-12);
}

TEST(SlowModes, at_the_threshold_are_the_order_as_well_and_sound_that_the_densities_push) {
    // abar = 0: chi d_t p = -Abar grad rho - Bbar grad sigma for p along q, d_t sigma = -div p and
    // d_t rho = -(rho alpha/Gamma) div p, so that u^2 = C0/chi; what neither moves nor drives it stands.
    Letters l;
    l.a = l.lambda * l.alpha / l.gamma;
    const Equations equations(flock_model(l));
    const LongWaves waves = long_waves(equations, isotropic_of(equations));
    ASSERT_EQ(waves.why_none, "");
    for (const double angle : {0.0, 0.3}) {
        const std::vector<SlowMode> modes = slow_modes(waves, angle);
        ASSERT_EQ(modes.size(), 4u);
        const double sound = std::sqrt(l.c0() / l.chi());
        EXPECT_NEAR(modes.front().speed.real(), -sound, 1e-12);
        EXPECT_NEAR(modes.back().speed.real(), sound, 1e-12);
        for (const std::size_t k : {1u, 2u}) EXPECT_NEAR(std::abs(modes[k].speed), 0.0, 1e-12);
    }
}

TEST(SlowModes, of_a_defective_speed_have_no_damping_and_count_as_growing) {
    // Without w, Bbar and Abar the slow order moves with neither density but drives both: u = 0 twice, once without a
    // vector of its own.
    Letters l{.e = 0.0, .f = 0.0, .w = 0.0, .pressure_a = 0.0, .pressure_b = 0.0};
    const LongWaves waves = flock_waves(l);
    bool defective = false;
    for (const SlowMode& mode : slow_modes(waves, pi / 2.0)) defective = defective || std::isnan(mode.damping.real());
    EXPECT_TRUE(defective);
    EXPECT_LT(slow_growth(waves, pi / 2.0).margin(), 0.0);
}

// ---- banding: rods only, abar(sigma)

struct Banding {
    double slope = 0.8, b = 0.7, pressure = 0.6, w = 0.5, k = 0.9;
    double margin_of_order() const { return slope * slope / (4.0 * b * pressure + 2.0 * w * slope); }
    Model model(double abar) const {
        return {.uniform = {.rod_density = 1.0},
                .current = {.speed = 1.0},
                .relaxation = {.rate = abar + slope, .rate_terms = {text("{} sigma", -slope)}, .saturation = b},
                .elasticity = {.stiffness = 0.4 * k, .splay = 0.6 * k},
                .advection = {.strength = w},
                .pressure = {.rods = pressure}};
    }
    double neutral(double abar) const {
        const double p0 = std::sqrt(-abar / b), turn = slope / (2.0 * b * p0), nu = -2.0 * abar;
        return std::sqrt(nu / k *
                         ((-w * p0 * turn + std::sqrt(std::pow(w * p0 * turn, 2) + 4.0 * pressure * turn * turn)) /
                              (2.0 * pressure) -
                          1.0));
    }
};

TEST(Banding, of_rods_begins_at_the_closed_form_threshold) {
    const Banding rods;
    const auto growth_at = [&](double abar) {
        const Equations equations(rods.model(abar));
        return slow_growth(long_waves(equations, flock_of(equations)), 0.0).second;
    };
    double low = -1.0, high = -0.01;
    ASSERT_LT(growth_at(low), 0.0);
    ASSERT_GT(growth_at(high), 0.0);
    for (int i = 0; i < 60; ++i) (growth_at(0.5 * (low + high)) > 0.0 ? high : low) = 0.5 * (low + high);
    EXPECT_NEAR(low, -rods.margin_of_order(), 1e-12);
}

TEST(Banding, of_rods_has_the_neutral_wave_of_the_closed_form) {
    const Banding rods;
    for (const double part : {0.1, 0.5, 0.9}) {
        const double abar = -part * rods.margin_of_order();
        const Equations equations(rods.model(abar));
        const StationaryState flock = flock_of(equations);
        const std::vector<theory::Band> found =
            theory::growth_bands(*linearised(equations, flock.point), 0.0, {.min = 1e-3, .max = 10.0});
        ASSERT_EQ(found.size(), 1u);
        EXPECT_TRUE(found[0].reaches_min);
        EXPECT_NEAR(found[0].max / rods.neutral(abar), 1.0,
                    1e-10);  // bisection of a growth that is 1e-16 of rates uncertain
        const std::vector<theory::Instability> grows = instabilities(equations, flock, {.min = 1e-3, .max = 10.0});
        ASSERT_FALSE(grows.empty());
        const auto bands = std::find_if(grows.begin(), grows.end(), [](const theory::Instability& i) {
            return i.kind == theory::InstabilityKind::banding;
        });
        ASSERT_NE(bands, grows.end());
        EXPECT_NEAR(bands->max / rods.neutral(abar), 1.0, 1e-10);
        EXPECT_EQ(bands->min, 0.0);
        EXPECT_EQ(bands->angle, 0.0);
        EXPECT_LT(bands->q, bands->max);
    }
}

TEST(Banding, near_onset_with_beads_needs_the_slope_by_what_the_current_carries) {
    // abar_s + (rho0 alpha/Gamma) abar_rho and C0 in place of abar_s and Bbar, chi times the square of the slope
    // (beads have inertia:
    // chi s^2 + nu s + ... = 0), to leading order in abar: the error of the predicted
    // |abar| of the boundary is of relative order |abar| (or its root), so it falls at least by two when slopes do by
    // four.  16 halvings find it to 6e-5.
    double last = 0.0;
    for (const double scale : {0.04, 0.01, 0.0025}) {
        const double by_rods = -0.5 * scale, by_beads = -0.3 * scale;
        const auto model = [&](double abar) {
            Letters l{.w = 0.0};
            Model m = flock_model(l);
            m.relaxation.rate = l.a - l.abar() + abar - by_rods * m.uniform.rod_density - by_beads * l.rho;
            m.relaxation.rate_terms = {text("{} sigma", by_rods), text("{} rho", by_beads)};
            return m;
        };
        const auto growth_at = [&](double abar) {
            const Equations equations(model(abar));
            const std::vector<SlowMode> all = slow_modes(long_waves(equations, flock_of(equations)), 0.0);
            return -std::max_element(all.begin(), all.end(), [](const SlowMode& a, const SlowMode& b) {
                        return a.speed.real() < b.speed.real();
                    })->damping.real();  // the mode that the slopes make fast: abar_s/(2 b p0)
        };
        const Letters l;
        const double slope = -(by_rods + l.rho * l.alpha / l.gamma * by_beads),
                     expected = -l.chi() * slope * slope / (4.0 * l.b * l.c0());
        double low = 4.0 * expected, high = 0.1 * expected;
        ASSERT_LT(growth_at(low), 0.0);
        ASSERT_GT(growth_at(high), 0.0);
        for (int i = 0; i < 16; ++i) (growth_at(0.5 * (low + high)) > 0.0 ? high : low) = 0.5 * (low + high);
        const double wrong = std::abs(low / expected - 1.0);
        if (last > 0.0) {
            EXPECT_LT(wrong, 0.55 * last);
        }
        last = wrong;
    }
    EXPECT_LT(last, 0.1);
}

}  // namespace
}  // namespace drover::physics::long_waves_tests
