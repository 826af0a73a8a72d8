// tests/numerics/block.cpp: functions of small matrices against 113-bit arithmetic and independent methods.
#include "drover/numerics/block.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>

#include "drover/base/error.hpp"
#include "numerics/extended.hpp"
#include "numerics/rod_bead_operator.hpp"

namespace drover::numerics::block_tests {
namespace {

using test::Quad;
using test::QuadMatrix;
using test::RodBeadCoefficients;

struct Mode {
    std::complex<double> rate;
    std::vector<std::complex<double>> vector;  // of unit length
};

std::vector<Mode> modes_of(const Block& block) {
    using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
    Extended m(block.size, block.size);
    for (int i = 0; i < block.size; ++i)
        for (int j = 0; j < block.size; ++j) m(i, j) = block(i, j);
    const Eigen::EigenSolver<Extended> solver(m);
    std::vector<Mode> modes;
    for (int k = 0; k < block.size; ++k) {
        Mode mode;
        mode.rate = static_cast<std::complex<double>>(solver.eigenvalues()(k));
        for (int i = 0; i < block.size; ++i)
            mode.vector.push_back(
                static_cast<std::complex<double>>(solver.eigenvectors()(i, k) / solver.eigenvectors().col(k).norm()));
        modes.push_back(mode);
    }
    return modes;
}

/// |(x - y) v| for a matrix in double and one in extended precision.
double difference_on(const Block& x, const QuadMatrix& y, const std::vector<std::complex<double>>& v) {
    double squares = 0.0;
    for (int i = 0; i < x.size; ++i) {
        Quad real = 0, imaginary = 0;
        double applied_real = 0.0, applied_imaginary = 0.0;
        for (int j = 0; j < x.size; ++j) {
            const auto& part = v[static_cast<std::size_t>(j)];
            real += y(i, j) * part.real();
            imaginary += y(i, j) * part.imag();
            applied_real += x(i, j) * part.real();
            applied_imaginary += x(i, j) * part.imag();
        }
        squares += std::pow(static_cast<double>(real - applied_real), 2) +
                   std::pow(static_cast<double>(imaginary - applied_imaginary), 2);
    }
    return std::sqrt(squares);
}

double largest_rate(const std::vector<Mode>& modes) {
    double largest = 0.0;
    for (const Mode& mode : modes) largest = std::max(largest, std::abs(mode.rate));
    return largest;
}

// The size of the propagated vector, exp(Re s dt), is the scale of the error; for modes that decay to nothing in a step
// it is the size of the vector itself, except for the slowest one, which is held to its own size.
void expect_right_on_every_mode(const Block& block, double dt_rate, double q) {
    const std::vector<Mode> modes = modes_of(block);
    const double dt = dt_rate / largest_rate(modes);
    const PhiFunctions phi = phi_functions(block, dt);
    const QuadMatrix reference = test::exponential(QuadMatrix(block), dt);
    const Mode* slowest = &modes.front();
    for (const Mode& mode : modes) {
        const double scale = std::max(1.0, std::exp(mode.rate.real() * dt));
        EXPECT_LT(difference_on(phi[0], reference, mode.vector), 1e-11 * scale)
            << "q = " << q << ", s = " << mode.rate << ", dt|s|max = " << dt_rate;
        if (std::abs(mode.rate) < std::abs(slowest->rate)) slowest = &mode;
    }
    EXPECT_LT(difference_on(phi[0], reference, slowest->vector), 1e-11 * std::exp(slowest->rate.real() * dt))
        << "slowest mode, q = " << q << ", s = " << slowest->rate << ", dt|s|max = " << dt_rate;
}

const RodBeadCoefficients decaying;               // a above lambda alpha/Gamma: no order
const RodBeadCoefficients growing{.decay = 0.1};  // and below: order grows
const RodBeadCoefficients stiff{.drag = 2000.0, .eta = 50.0};
constexpr int wavenumbers = 20;
double wavenumber(int i) { return 0.01 * std::pow(1000.0, i / (wavenumbers - 1.0)); }  // 0.01 to 10

TEST(Propagator, its_error_is_below_1e_11_on_every_eigenvector_of_both_blocks) {
    for (const RodBeadCoefficients& coefficients : {decaying, growing, stiff})
        for (int i = 0; i < wavenumbers; ++i)
            for (const double dt_rate : {0.01, 1.0, 100.0}) {
                const double q = wavenumber(i);
                const IsotropicBlocks m = test::rod_bead_operator(coefficients, q);
                expect_right_on_every_mode(m.even, dt_rate, q);
                expect_right_on_every_mode(m.odd, dt_rate, q);
            }
}

TEST(Propagator, order_grows_only_below_the_mean_field_threshold) {
    // The test above uses both cases.
    const auto fastest = [](const RodBeadCoefficients& c) {
        double rate = -INFINITY;
        for (const Mode& mode : modes_of(test::rod_bead_operator(c, 0.01).odd)) rate = std::max(rate, mode.rate.real());
        return rate;
    };
    EXPECT_LT(fastest(decaying), 0.0);
    EXPECT_GT(fastest(growing), 0.0);
}

// phi_k of the augmented matrix [[z, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]: its exponential holds phi_1
// to phi_3 in its first row, that of a larger one the higher ones.  For a scalar z this is an independent reference.
TEST(PhiFunctions, of_a_scalar_are_those_of_the_augmented_exponential_from_tiny_to_huge_arguments) {
    for (const double z : {-1e9, -4e3, -100.0, -3.0, -0.4, -1e-3, -1e-9, 0.0, 1e-9, 0.3, 2.0, 30.0}) {
        Block m(1);
        m(0, 0) = z;
        QuadMatrix augmented(max_phi + 1);
        augmented(0, 0) = z;
        for (int i = 0; i < max_phi; ++i) augmented(i, i + 1) = 1;
        const QuadMatrix e = test::exponential(augmented, 1);
        for (const int highest : {3, 6, max_phi}) {
            const PhiFunctions phi = phi_functions(m, 1.0, highest);
            ASSERT_EQ(phi.size(), static_cast<std::size_t>(highest) + 1);
            for (int k = 0; k <= highest; ++k) {
                const double expected = static_cast<double>(e(0, k));
                // Rounding of the result, and the error of 30 squarings of the reference at z = -1e9.
                EXPECT_NEAR(phi[static_cast<std::size_t>(k)](0, 0), expected, 4e-16 * std::abs(expected) + 1e-300)
                    << "phi_" << k << "(" << z << ") of " << highest;
            }
        }
    }
}

TEST(NoiseTree, has_the_bits_of_its_covariance_and_of_its_halves) {
    for (const double dt : {1e-4, 0.05, 3.0, 12.8})
        for (const double q : {0.0, 0.3, 7.0})
            for (const Block& m :
                 {test::rod_bead_operator(decaying, q).even, test::rod_bead_operator(decaying, q).odd}) {
                Block noise(m.size);
                noise(m.size - 1, m.size - 1) = 0.5;
                const NoiseTree tree = noise_tree(m, noise, dt, 7);
                EXPECT_EQ(tree.covariance, noise_tree(m, noise, dt, 0).covariance);
                const std::vector<NoiseHalves> halves = noise_tree(m, noise, 0.5 * dt, 6).halves;
                ASSERT_EQ(tree.halves.size(), halves.size() + 1);
                for (std::size_t k = 0; k < halves.size(); ++k) {
                    EXPECT_EQ(tree.halves[k + 1].regression, halves[k].regression);
                    EXPECT_EQ(tree.halves[k + 1].spread, halves[k].spread);
                    EXPECT_EQ(tree.halves[k + 1].propagator, halves[k].propagator);
                }
            }
}

TEST(PhiFunctions, of_blocks_obey_their_recurrence) {
    for (const double dt : {1e-4, 0.05, 3.0}) {
        const Block m = test::rod_bead_operator(decaying, 0.7).even;
        const PhiFunctions phi = phi_functions(m, dt, max_phi);
        double norm = 0.0;
        for (const double value : m.values()) norm = std::max(norm, std::abs(value) * dt);
        for (std::size_t k = 0; k + 1 < phi.size(); ++k)
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j) {
                    double product = i == j ? 1.0 / std::tgamma(static_cast<double>(k) + 1.0) : 0.0;
                    for (int l = 0; l < 4; ++l) product += dt * m(i, l) * phi[k + 1](l, j);
                    // Rounded entries times entries of z.
                    EXPECT_NEAR(phi[k](i, j), product, 1e-15 * (1.0 + 16.0 * norm)) << k << i << j << " dt " << dt;
                }
    }
}

// To the last digit: halving a step halves z exactly, and each step is made by the same doublings.
TEST(PhiFunctions, of_halved_steps_are_those_of_each_step) {
    for (const double dt : {1e-3, 0.05, 3.0, 40.0}) {
        const Block m = test::rod_bead_operator(decaying, 0.7).even;
        const std::vector<PhiFunctions> found = phi_functions_of_halves(m, dt, 5, 4);
        ASSERT_EQ(found.size(), 5u);
        for (int k = 0; k < 5; ++k) {
            const PhiFunctions expected = phi_functions(m, std::ldexp(dt, -k), 4);
            for (std::size_t n = 0; n <= 4; ++n)
                EXPECT_EQ(found[static_cast<std::size_t>(k)][n], expected[n]) << k << " phi " << n;
        }
    }
}

TEST(PhiFunctions, a_mode_that_overflows_in_one_step_is_rejected) {
    Block m(2);
    m(0, 0) = 1.0;
    EXPECT_THROW(phi_functions(m, 1000.0), Error);
    EXPECT_THROW(noise_tree(m, m, 1000.0, 0).covariance, Error);
}

/// Largest error of c in units of the deviations of the two variables.
double scaled_error(const Block& c, const QuadMatrix& reference) {
    double worst = 0.0;
    for (int i = 0; i < c.size; ++i)
        for (int j = 0; j < c.size; ++j) {
            const long double scale =
                std::sqrt(static_cast<long double>(reference(i, i)) * static_cast<long double>(reference(j, j)));
            const auto error = static_cast<long double>(test::size(reference(i, j) - c(i, j)));
            if (scale > 0.0L) worst = std::max(worst, static_cast<double>(error / scale));
            else EXPECT_EQ(c(i, j), 0.0);
        }
    return worst;
}

Block multiplied_by_its_transpose(const Block& f) {
    Block c(f.size);
    for (int i = 0; i < f.size; ++i)
        for (int j = 0; j < f.size; ++j)
            for (int k = 0; k < f.size; ++k) c(i, j) += f(i, k) * f(j, k);
    return c;
}

void expect_right_covariance(const Block& m, const Block& q, double dt, bool small, const std::string& what) {
    const Block c = noise_tree(m, q, dt, 0).covariance;
    const QuadMatrix reference = small ? test::covariance_by_quadrature(QuadMatrix(m), QuadMatrix(q), dt)
                                       : test::covariance_by_difference(QuadMatrix(m), QuadMatrix(q), dt);
    for (int i = 0; i < c.size; ++i)
        for (int j = 0; j < c.size; ++j) ASSERT_TRUE(std::isfinite(c(i, j))) << what;
    EXPECT_LT(scaled_error(c, reference), 1e-10) << what;
    EXPECT_LT(scaled_error(multiplied_by_its_transpose(factor(c)), reference), 1e-10) << what << ", factor";
}

Block noise_on(int size, std::vector<int> variables) {
    Block q(size);
    for (const int i : variables) q(i, i) = 0.7 + 0.1 * i;
    return q;
}

TEST(NoiseCovariance, its_error_is_below_1e_10_for_dt_s_max_from_1e_minus_6_to_1e12) {
    for (const double q : {0.05, 0.8, 6.0})
        for (double dt_rate = 1e-6; dt_rate < 2e12; dt_rate *= 10.0) {
            const IsotropicBlocks m = test::rod_bead_operator(decaying, q);
            for (const std::vector<int>& noisy :
                 {std::vector<int>{3}, std::vector<int>{1, 3}, std::vector<int>{0, 1, 2, 3}}) {
                const double dt = dt_rate / largest_rate(modes_of(m.even));
                expect_right_covariance(m.even, noise_on(4, noisy), dt, dt_rate <= 1.0,
                                        "along, q " + std::to_string(q) + ", dt|s|max " + std::to_string(dt_rate));
            }
            const double dt = dt_rate / largest_rate(modes_of(m.odd));
            expect_right_covariance(m.odd, noise_on(2, {1}), dt, dt_rate <= 1.0,
                                    "across, q " + std::to_string(q) + ", dt|s|max " + std::to_string(dt_rate));
        }
}

TEST(NoiseCovariance, a_slow_mode_beside_one_faster_by_1e12_is_accurate) {
    Block m(2);  // drag rate 1e12 of the velocity, order that decays in a second
    m(0, 0) = -1e12;
    m(0, 1) = 3.0;
    m(1, 0) = 0.5;
    m(1, 1) = -1.0;
    for (const double dt : {1e-12, 1e-6, 1e-3, 1.0, 10.0}) {
        expect_right_covariance(m, noise_on(2, {1}), dt, false, "dt " + std::to_string(dt));
        const QuadMatrix reference = test::exponential(QuadMatrix(m), dt);
        EXPECT_NEAR(phi_functions(m, dt)[0](1, 1), static_cast<double>(reference(1, 1)),
                    1e-14 * static_cast<double>(reference(1, 1)));
    }
}

TEST(NoiseCovariance, of_a_growing_mode_it_is_that_of_the_quadrature) {
    const Block m = test::rod_bead_operator(growing, 0.05).odd;
    expect_right_covariance(m, noise_on(2, {1}), 0.06, true, "small step");
    expect_right_covariance(m, noise_on(2, {1}), 40.0, false, "a growth by e^15");
}

TEST(NoiseCovariance, of_a_defective_operator_it_is_the_closed_form) {
    Block m(2), q(2);  // da = -a + b, db = -b + noise: one eigenvector for both rates
    m(0, 0) = m(1, 1) = -1.0;
    m(0, 1) = 1.0;
    q(1, 1) = 2.0;
    for (const double t : {1e-3, 0.5, 4.0, 300.0}) {
        const Block c = noise_tree(m, q, t, 0).covariance;
        const double e = std::exp(-2.0 * t);
        EXPECT_NEAR(c(1, 1), -std::expm1(-2.0 * t), 1e-14 * c(1, 1));
        if (t > 0.1) {  // below, the closed forms cancel; the series of the integrals is tested above
            EXPECT_NEAR(c(0, 1), 0.5 * (1.0 - e * (1.0 + 2.0 * t)), 1e-13);
            EXPECT_NEAR(c(0, 0), 0.5 * (1.0 - e * (1.0 + 2.0 * t + 2.0 * t * t)), 1e-13);
        }
    }
}

TEST(NoiseHalves, have_the_covariances_of_two_independent_intervals) {
    // With first = K whole + S xi and second = whole - E first: <first first^T> = C and <first second^T> = 0.
    using namespace test;
    const auto error = [](const QuadMatrix& found, const QuadMatrix& expected, const QuadMatrix& scale) {
        double worst = 0.0;
        for (int i = 0; i < found.n; ++i)
            for (int j = 0; j < found.n; ++j)
                worst =
                    std::max(worst, static_cast<double>(test::size(found(i, j) - expected(i, j))) /
                                        std::sqrt(static_cast<double>(scale(i, i)) * static_cast<double>(scale(j, j))));
        return worst;
    };
    for (const double q : {0.05, 0.8, 6.0})
        for (double dt_rate = 1e-6; dt_rate < 2e6; dt_rate *= 10.0) {
            const IsotropicBlocks m = test::rod_bead_operator(decaying, q);
            const double dt = dt_rate / largest_rate(modes_of(m.even));
            for (const std::vector<int>& noisy : {std::vector<int>{3}, std::vector<int>{0, 1, 2, 3}}) {
                const Block noise = noise_on(4, noisy);
                const auto covariance = [&](double t) {
                    return dt_rate <= 1.0 ? covariance_by_quadrature(QuadMatrix(m.even), QuadMatrix(noise), t)
                                          : covariance_by_difference(QuadMatrix(m.even), QuadMatrix(noise), t);
                };
                const QuadMatrix half = covariance(dt), whole = covariance(2.0 * dt);
                const NoiseHalves found = noise_tree(m.even, noise, 2.0 * dt, 1).halves.front();
                const QuadMatrix k(found.regression), s(found.spread), e(found.propagator),
                    with_whole = product(k, whole),
                    first = sum(product(with_whole, transposed(k)), product(s, transposed(s))),
                    between = sum(with_whole, scaled(product(first, transposed(e)), -1));
                // K reaches 1e9 where variables follow each other closely, and its entries are rounded at 1e-16.  A
                // direction of less than 1e-14 of the variance is left out, of correlation 1e-7.  Both are far below
                // what a sample can show.
                EXPECT_LT(error(first, half, half), 5e-6) << "q " << q << ", dt|s|max " << dt_rate;
                EXPECT_LT(error(between, QuadMatrix(4), half), 5e-6) << "q " << q << ", dt|s|max " << dt_rate;
            }
        }
}

TEST(NoiseHalves, of_noise_without_a_law_are_a_brownian_bridge) {
    const NoiseHalves found = noise_tree(Block(1), noise_on(1, {0}), 0.5, 1).halves.front();
    EXPECT_DOUBLE_EQ(found.regression(0, 0), 0.5);
    EXPECT_DOUBLE_EQ(found.spread(0, 0), std::sqrt(0.7 * 0.25 / 2.0));
    EXPECT_DOUBLE_EQ(found.propagator(0, 0), 1.0);
}

TEST(NoiseCovariance, of_a_conserved_mean_and_without_noise_it_is_exact) {
    const Block still(3);
    Block q = noise_on(3, {0, 2});
    const Block c = noise_tree(still, q, 0.25, 0).covariance;
    for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(c(i, i), 0.25 * q(i, i));
    const Block none = noise_tree(test::rod_bead_operator(decaying, 1.0).even, Block(4), 1.0, 0).covariance;
    for (const double value : none.values()) EXPECT_EQ(value, 0.0);
    for (const double value : factor(none).inside) EXPECT_EQ(value, 0.0);
}

TEST(Factor, covariances_of_lower_rank_and_of_very_different_scales_are_factored) {
    // rank 2 in three variables, deviations 1e-12, 1, 1e9; correlations exact in binary
    const double rows[3][2] = {{1e-12, 0.0}, {0.5, 0.25}, {1e9, -3e9}};
    Block c(3);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) c(i, j) = rows[i][0] * rows[j][0] + rows[i][1] * rows[j][1];
    EXPECT_LT(scaled_error(multiplied_by_its_transpose(factor(c)), QuadMatrix(c)), 1e-14);
}

TEST(Factor, a_matrix_that_is_not_a_covariance_is_rejected) {
    Block negative(1);
    negative(0, 0) = -1.0;
    EXPECT_THROW(factor(negative), Error);
    Block indefinite(2);
    indefinite(0, 0) = indefinite(1, 1) = 1.0;
    indefinite(0, 1) = indefinite(1, 0) = 1.001;
    EXPECT_THROW(factor(indefinite), Error);
}

TEST(StationaryCovariance, of_the_transverse_block_is_the_closed_form) {
    // S_pp = (Delta/2)(g^2 + g h - k)/[(g + h)(g h - k)]
    const RodBeadCoefficients c;
    for (const double q : {0.0, 0.3, 2.0}) {
        const double g = (c.drag + c.eta * q * q) / c.rho0, h = c.decay + c.stiffness * q * q,
                     k = c.weathercock * c.alpha / c.rho0;
        const Block s = stationary_covariance(test::rod_bead_operator(c, q).odd, noise_on(2, {1}));
        const double expected = 0.5 * 0.8 * (g * g + g * h - k) / ((g + h) * (g * h - k));
        EXPECT_NEAR(s(1, 1), expected, 1e-14 * expected);
    }
}

TEST(StationaryCovariance, is_rejected_where_a_mode_grows_or_does_not_decay) {
    EXPECT_THROW(stationary_covariance(test::rod_bead_operator(growing, 0.05).odd, noise_on(2, {1})), Error);
    EXPECT_THROW(stationary_covariance(Block(1), noise_on(1, {0})), Error);
}

TEST(Eigenvalues, do_not_depend_on_the_unit_of_one_variable) {
    // Similar to a matrix with the eigenvalues -1, -2, -3.
    const double m[3][3] = {{-1.0, 0.5, 0.25}, {0.0, -2.0, 0.5}, {0.0, 0.0, -3.0}},
                 turn[3][3] = {{1, 1, 0}, {0, 1, 1}, {1, 0, 1}},
                 back[3][3] = {{0.5, -0.5, 0.5}, {0.5, 0.5, -0.5}, {-0.5, 0.5, 0.5}};
    for (const double unit : {1.0, 0x1p-24, 0x1p24, 0x1p50}) {
        Block block(3);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) {
                double sum = 0.0;
                for (int a = 0; a < 3; ++a)
                    for (int b = 0; b < 3; ++b) sum += turn[i][a] * m[a][b] * back[b][k];
                block(i, k) = (i == 1 ? unit : 1.0) * sum / (k == 1 ? unit : 1.0);
            }
        for (const double expected : {-1.0, -2.0, -3.0}) {
            double nearest = 1.0;
            for (const std::complex<double>& s : eigenvalues(block))
                nearest = std::min(nearest, std::abs(s - expected));
            EXPECT_LT(nearest, 1e-13) << unit;  // some ten roundings of 3, by the angles between vectors
        }
    }
}

}  // namespace
}  // namespace drover::numerics::block_tests
