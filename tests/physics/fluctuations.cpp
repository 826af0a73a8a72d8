// tests/physics/fluctuations.cpp: stationary fluctuations about uniform states, by independent methods.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "flock_model.hpp"
#include "linear_modes.hpp"
#include "physics/rod_bead_model.hpp"
#include "symbols.hpp"
#include "whole_rate.hpp"

namespace drover::physics::fluctuations_tests {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

Model noisy(const Letters& letters) {
    Model model = flock_model(letters);
    model.noise = {.order = 0.3, .rods = 0.12, .beads = 0.07};
    model.diffusion = {.beads = 0.05, .rods = 0.04};
    return model;
}

/// m s + s m^H + q = 0 as linear equations for the entries of s.
Symbol by_kronecker(const Symbol& m, const Symbol& q) {
    Eigen::MatrixXcd whole = Eigen::MatrixXcd::Zero(36, 36);
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
            for (int k = 0; k < 6; ++k) {
                whole(6 * i + j, 6 * k + j) += m(i, k);
                whole(6 * i + j, 6 * i + k) += std::conj(m(j, k));
            }
    Eigen::VectorXcd right(36);
    for (int i = 0; i < 36; ++i) right(i) = -q(i / 6, i % 6);
    const Eigen::VectorXcd s = whole.fullPivLu().solve(right);
    Symbol result;
    for (int i = 0; i < 36; ++i) result(i / 6, i % 6) = s(i);
    return result;
}

Symbol noise_of(const Equations& e, const UniformPoint& about, const numerics::Wavevector& q) {
    const auto at = linearised(e, about);
    return of_all_fields(e, at->noise(q), at->state_components());
}

TEST(StructureMatrix, of_a_flock_solves_its_lyapunov_equation) {
    const Equations e(noisy({}));
    const UniformPoint flock = flock_of(e).point;
    for (const double q : {0.03, 0.5, 4.0})
        for (const double angle : {0.0, 0.9, pi / 2.0, 4.0}) {
            const numerics::Wavevector at = wavevector_from_order(flock, q, angle);
            const Symbol found = structure_matrix(e, flock, at),
                         expected = by_kronecker(linear_symbol(e, flock, at), noise_of(e, flock, at));
            // Rounding times the condition: the fastest rate over the slowest, some 1e3 at q = 0.03.
            EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff())
                << q << ", " << angle;
        }
}

TEST(StructureMatrix, of_the_isotropic_order_across_q_is_the_closed_form) {
    const Letters l = isotropic_letters();
    const Equations e(noisy(l));
    for (const double q : {0.1, 1.3}) {
        const double g = (l.gamma + l.eta * q * q) / l.rho, h = l.a + l.k3 * q * q, k = l.lambda * l.alpha / l.rho;
        const double expected = 0.5 * 0.3 * (g * g + g * h - k) / ((g + h) * (g * h - k));
        EXPECT_NEAR(structure_matrix(e, isotropic_of(e).point, {.x = q, .y = 0.0})(FieldIndex::polar_order_y,
                                                                                   FieldIndex::polar_order_y)
                        .real(),
                    expected, 1e-13);
    }
}

TEST(StructureMatrix, of_a_defective_mode_matches_the_closed_form) {
    // Damped sound at its double root, driven by noise on the density.
    Letters l{.alpha = 0.0, .f = 0.0, .lambda = 0.0};
    Model model = noisy(l);
    model.viscosity = {};
    model.diffusion.beads = 0.0;
    const Equations e(model);
    const double q = l.gamma / (2.0 * l.rho * std::sqrt(l.e));
    const numerics::Wavevector at{.x = q, .y = 0.0};
    const UniformPoint rest = isotropic_of(e).point;
    // d_t n = -i rho q v + noise, d_t v = -i E q n/rho - (Gamma/rho) v: S_nn = Q/2 (Gamma/rho)/(q^2 E) + Q rho/(2
    // Gamma).
    const double noise = 0.07 * q * q, damping = l.gamma / l.rho;
    const double expected = 0.5 * noise * (damping / (l.e * q * q) + 1.0 / damping);
    EXPECT_NEAR(structure_matrix(e, rest, at)(FieldIndex::bead_density, FieldIndex::bead_density).real(), expected,
                1e-13);
}

TEST(StructureMatrix, of_a_growing_mode_throws_a_run_error) {
    const Equations e(noisy({}));
    try {
        structure_matrix(e, isotropic_of(e).point, {.x = 0.1, .y = 0.0});
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("no stationary state: a mode at q = (0.1, 0) /mm grows at"),
                  std::string::npos);
    }
}

TEST(DynamicStructure, integrates_to_the_equal_time_structure) {
    const Equations e(noisy({}));
    const UniformPoint flock = flock_of(e).point;
    const numerics::Wavevector at = wavevector_from_order(flock, 0.4, 1.0);
    // omega = W tan(x): the integrand is periodic and smooth in x, so that equal steps converge faster than any power.
    Symbol sum = Symbol::Zero();
    constexpr int count = 4000;
    for (int n = 0; n < count; ++n) {
        const double x = pi * ((n + 0.5) / count - 0.5), c = std::cos(x);
        sum += dynamic_structure_matrix(e, flock, at, std::tan(x)) / (c * c) * (pi / count) / (2.0 * pi);
    }
    const Symbol expected = structure_matrix(e, flock, at);
    EXPECT_LT((sum - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.cwiseAbs().maxCoeff());
}

TEST(DynamicStructure, of_a_flock_peaks_at_its_sound) {
    // Weakly damped waves across p0: the rods' spectrum has its two peaks at -Im s.
    Letters l{.k3 = 0.05, .k1 = 0.0};
    const Equations e(noisy(l));
    const UniformPoint flock = flock_of(e).point;
    const double q = 0.05, sound = q * std::sqrt(l.c0() / l.chi());
    const numerics::Wavevector at = wavevector_from_order(flock, q, pi / 2.0);
    double best = 0.0, largest = 0.0;
    for (int n = 1; n < 2000; ++n) {
        const double omega = 2.0 * sound * n / 2000.0,
                     s = dynamic_structure_matrix(e, flock, at, omega)(FieldIndex::polar_order_y,
                                                                       FieldIndex::polar_order_y)
                             .real();
        if (s > largest) largest = s, best = omega;
    }
    EXPECT_NEAR(best, sound, 0.02 * sound);  // the damping, gamma q^2/sound = 1 %
}

TEST(StructureFactors, about_the_isotropic_state_are_those_of_its_blocks) {
    // Two programs: 4 by 4 and 2 by 2 real blocks of |q|, and the complex matrix of the wavevector.
    const Equations e(noisy(isotropic_letters()));
    const numerics::Grid grid{16, 12, 9.0, 7.0};
    const numerics::System system = linear_system(e, grid, mean_densities(e.model));
    Threads threads(2);
    const std::vector<StructureFactor> blocks = structure_factors(system, physics::form(e.model)),
                                       found =
                                           structure_factors(e, isotropic_of(e).point, grid, system.degree, threads);
    ASSERT_EQ(blocks.size(), found.size());
    for (std::size_t m = 0; m < found.size(); ++m)
        for (const auto part : {&StructureFactor::rods, &StructureFactor::beads, &StructureFactor::order_along,
                                &StructureFactor::order_across, &StructureFactor::velocity_along,
                                &StructureFactor::velocity_across, &StructureFactor::beads_rods})
            EXPECT_NEAR(found[m].*part, blocks[m].*part, 1e-12 * (1.0 + std::abs(blocks[m].*part)));
}

double direction_diffusion(const Equations& e) {
    const auto at = linearised(e, flock_of(e).point);
    return theory::direction_diffusion(*at, theory::long_waves(*at));
}

TEST(DirectionDiffusion, of_a_flock_is_the_closed_form) {
    const Letters l;
    const Equations e(noisy(l));
    EXPECT_NEAR(direction_diffusion(e), 0.5 * 0.3 / std::pow(l.p0() * l.chi(), 2), 1e-14);
    Model struck = noisy(l);
    struck.noise = {.velocity = 0.7};
    const Equations driven(struck);
    const double turned = l.lambda * l.rho / l.gamma;  // of the order, by one of the beads' velocity
    EXPECT_NEAR(direction_diffusion(driven), 0.5 * 0.7 * std::pow(turned / (l.p0() * l.chi()), 2), 1e-14);
    Model slaved = noisy(l);
    slaved.fields.bead_velocity = "slaved";
    const Equations quick(slaved);
    EXPECT_NEAR(direction_diffusion(quick), 0.5 * 0.3 / std::pow(l.p0(), 2), 1e-14);
}

}  // namespace
}  // namespace drover::physics::fluctuations_tests
