// tests/numerics/dense.cpp: decompositions reproduce the matrix.
#include "numerics/algebra/dense.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace drover::numerics::dense_tests {
namespace {

/// Arbitrary reproducible entries of order one.
Eigen::MatrixXcd sample(int rows) {
    Eigen::MatrixXcd m(rows, rows);
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < rows; ++k) m(i, k) = {std::sin(1.0 + 7.0 * i + 3.0 * k), std::cos(2.0 + 5.0 * i - 2.0 * k)};
    return m;
}

// Backward stable algorithms: a few n ulp of |m| < 2 n, times the condition of the eigenvectors for those.
constexpr double rounding = 1e-13;

TEST(DenseMatrices, eigenvectors_are_normalised_and_satisfy_the_eigenvalue_equation) {
    for (int rows = 1; rows <= max_small_rows; ++rows) {
        const Eigen::MatrixXcd m = sample(rows);
        const DenseEigen found = dense_eigen(m);
        EXPECT_LT((m * found.vectors - found.vectors * found.values.asDiagonal()).norm(), rounding);
        for (int k = 0; k < rows; ++k) EXPECT_NEAR(found.vectors.col(k).norm(), 1.0, rounding);
        EXPECT_EQ(dense_eigenvalues(m), found.values);
    }
}

TEST(PreciseEigenvalues, agree_with_double_precision_where_that_is_accurate) {
    for (int rows = 1; rows <= max_small_rows; ++rows) {
        const Eigen::MatrixXcd m = sample(rows);
        const DenseEigen found = precise_eigen(m);
        EXPECT_LT((m * found.vectors - found.vectors * found.values.asDiagonal()).norm(), rounding);
        const Eigen::VectorXcd values = dense_eigenvalues(m);
        for (const std::complex<double>& value : values)
            EXPECT_LT((found.values.array() - value).abs().minCoeff(), rounding);
    }
}

TEST(PreciseEigenvalues, of_a_slow_mode_beside_a_very_fast_one_have_all_digits) {
    // det and trace are exact: the slow eigenvalue is det/trace to 1 part in 2^90.  Double precision gives 0 or 1e-4.
    const double fast = -0x1p40, slow = -0x1p-25;
    Eigen::MatrixXcd m(2, 2);
    m << fast, 1.0, 0.0, slow;
    m(1, 0) = 0x1p-10;
    const double expected = (fast * slow - m(1, 0).real()) / (fast + slow);
    const Eigen::VectorXcd values = reliable_eigenvalues(m);
    EXPECT_NEAR(std::max(values(0).real(), values(1).real()), expected, 1e-15 * std::abs(expected));
    EXPECT_NEAR(std::min(values(0).real(), values(1).real()), fast, 1e-15 * std::abs(fast));
}

TEST(PreciseEigenvalues, of_two_slow_modes_beside_a_very_fast_one_are_roots_of_the_characteristic_polynomial) {
    // A density, a velocity with drag 2e12 /s and an order: s (g + s)(s + 1/4) - 4 s + ab (s + 17/4) = 0.  In double
    // precision the two slow modes, -0.0005 and -0.25 /s, come out as waves of 700 /s.
    constexpr double a = 0x1p-10, b = 0x1p36, g = 0x1p41;
    const std::complex<double> i(0.0, 1.0);
    Eigen::MatrixXcd m(3, 3);
    m << 0.0, -i * a, 0.0, -i * b, -g, 4.0, -i * b, 1.0, -0.25;
    int slow = 0;
    for (const std::complex<double>& s : reliable_eigenvalues(m)) {
        if (std::abs(s) > 1e6) continue;
        ++slow;
        const std::complex<double> drag = s * (g + s) * (s + 0.25), rest = -4.0 * s + a * b * (s + 4.25);
        EXPECT_LT(std::abs(drag + rest), 1e-6 * std::abs(rest));  // the six digits that are promised
        EXPECT_LT(std::abs(s), 0.3);
    }
    EXPECT_EQ(slow, 2);
}

TEST(PreciseEigenvalues, of_sound_that_is_hardly_damped_has_its_damping) {
    // s^2 + 2 d s + w^2 = 0 with d = 1e-14 w: s = -d +- i sqrt(w^2 - d^2).
    const double damping = 0x1p-47;
    Eigen::MatrixXcd m(2, 2);
    m << 0.0, 1.0, -1.0, -2.0 * damping;
    for (const std::complex<double>& value : reliable_eigenvalues(m))
        EXPECT_NEAR(value.real(), -damping, 1e-15 * damping);
}

TEST(PreciseEigenvalues, of_defective_and_zero_matrices_are_found) {
    Eigen::MatrixXcd defective = Eigen::MatrixXcd::Zero(3, 3);
    defective(0, 1) = defective(1, 2) = 1e-300;
    for (const std::complex<double>& value : reliable_eigenvalues(defective)) EXPECT_EQ(value, 0.0);
    for (const std::complex<double>& value : reliable_eigenvalues(Eigen::MatrixXcd(Eigen::MatrixXcd::Zero(6, 6))))
        EXPECT_EQ(value, 0.0);
}

TEST(DenseMatrices, real_matrices_have_conjugate_pairs_of_eigenvalues) {
    Eigen::MatrixXd rotation(2, 2);
    rotation << 0.6, -0.8, 0.8, 0.6;
    const Eigen::VectorXcd values = dense_eigenvalues(rotation);
    EXPECT_NEAR(values(0).real(), 0.6, rounding);
    EXPECT_NEAR(std::abs(values(0).imag()), 0.8, rounding);
    EXPECT_EQ(values(0), std::conj(values(1)));
}

TEST(DenseMatrices, singular_value_decompositions_multiply_to_the_matrix) {
    for (int rows = 1; rows <= max_small_rows; ++rows) {
        const Eigen::MatrixXcd m = sample(rows), one = Eigen::MatrixXcd::Identity(rows, rows);
        const DenseSvd<Eigen::MatrixXcd> svd = dense_svd(m);
        EXPECT_LT((svd.left * svd.values.cast<std::complex<double>>().asDiagonal() * svd.right.adjoint() - m).norm(),
                  rounding);
        EXPECT_LT((svd.left * svd.left.adjoint() - one).norm(), rounding);
        for (int k = 1; k < rows; ++k) EXPECT_GE(svd.values(k - 1), svd.values(k));
    }
}

TEST(DenseMatrices, the_inverse_of_a_regular_matrix_multiplies_to_the_identity) {
    const Eigen::MatrixXcd m = sample(6) + 3.0 * Eigen::MatrixXcd::Identity(6, 6),
                           one = Eigen::MatrixXcd::Identity(6, 6);
    EXPECT_LT((m * inverse(m) - one).norm(), 1e-12);  // condition below 100
}

/// Powers of 2: units of the rows.
Eigen::VectorXd units(int rows) {
    Eigen::VectorXd result(rows);
    for (int i = 0; i < rows; ++i) result(i) = std::exp2(20 * (i % 3) - 25 * (i % 2));
    return result;
}

TEST(DenseMatrices, in_other_units_of_rows_and_columns_have_the_same_inverse_rank_and_solutions) {
    const Eigen::VectorXd u = units(5), v = u.reverse();
    const Eigen::MatrixXcd regular = sample(5) + 3.0 * Eigen::MatrixXcd::Identity(5, 5),
                           in_units = u.asDiagonal() * regular * v.asDiagonal(), right = sample(5).leftCols(2),
                           one = Eigen::MatrixXcd::Identity(5, 5);
    EXPECT_TRUE(is_invertible(in_units));
    const Eigen::MatrixXd real = regular.real(), real_in_units = in_units.real();
    EXPECT_LT((v.asDiagonal() * pivoted_inverse(real_in_units) * u.asDiagonal() * real - one.real()).norm(),
              1e-12);  // condition below 100
    EXPECT_LT((v.asDiagonal() * shortest_solution(in_units, u.asDiagonal() * right) - solution(regular, right)).norm(),
              1e-12);
    Eigen::MatrixXcd singular = regular;
    singular.col(2) = regular.col(0) - 0.5 * regular.col(4);
    EXPECT_FALSE(is_invertible(Eigen::MatrixXcd(u.asDiagonal() * singular * v.asDiagonal())));
}

TEST(DenseMatrices, in_other_units_have_the_same_exponential) {
    const Eigen::VectorXd u = units(5);
    const Eigen::MatrixXcd m = 0.3 * sample(5), expected = exponential(m),
                           found = exponential(u.asDiagonal() * m * u.cwiseInverse().asDiagonal());
    EXPECT_LT((u.cwiseInverse().asDiagonal() * found * u.asDiagonal() - expected).norm(), rounding * expected.norm());
}

TEST(DenseMatrices, without_rows_have_no_exponential_and_no_scales) {  // as at q = 0 of fields that are conserved
    const Eigen::MatrixXcd none(0, 0);
    EXPECT_EQ(exponential(none).size(), 0);
    EXPECT_EQ(balanced(none).size(), 0);
    EXPECT_EQ(even_scales(none).rows.size(), 0);
}

}  // namespace
}  // namespace drover::numerics::dense_tests
