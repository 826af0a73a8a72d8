// tests/numerics/lyapunov.cpp: the Lyapunov equation against its residual and against real blocks.
#include "numerics/algebra/dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <complex>

#include "drover/numerics/block.hpp"

namespace drover::numerics::lyapunov_tests {
namespace {

using Complex = std::complex<double>;
using Matrix = Eigen::MatrixXcd;

struct Solution {
    double growth = 0.0;
    Matrix s;
};

Solution solve(const Matrix& m, const Matrix& q) {
    Solution result{.growth = 0.0, .s = Matrix::Zero(m.rows(), m.cols())};
    result.growth = solve_lyapunov(m, q, result.s);
    return result;
}

/// Diagonally dominant, so that every mode decays.
Matrix decaying(int rows) {
    Matrix m(rows, rows);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < rows; ++j)
            m(i, j) = i == j ? Complex(-2.0 * rows - i, i) : Complex(std::cos(i + 2 * j), std::sin(3 * i - j));
    return m;
}

Matrix covariance(int rows) {
    const Matrix a = decaying(rows);
    return a * a.adjoint();
}

TEST(Lyapunov, the_solution_satisfies_the_equation_for_every_size) {
    for (int rows = 1; rows <= max_lyapunov; rows += rows < 8 ? 1 : 20) {
        const Matrix m = decaying(rows), q = covariance(rows);
        const auto [growth, s] = solve(m, q);
        EXPECT_LT(growth, 0.0);
        EXPECT_LT((m * s + s * m.adjoint() + q).cwiseAbs().maxCoeff(), 1e-13 * q.cwiseAbs().maxCoeff());  // rounding
        EXPECT_EQ(s, s.adjoint());
    }
}

TEST(Lyapunov, the_solution_of_a_defective_matrix_is_the_closed_form) {
    Matrix m(2, 2), q = Matrix::Zero(2, 2);
    m << -1.0, 1.0, 0.0, -1.0;  // da = -a + b, db = -b + noise
    q(1, 1) = 1.0;
    Matrix expected(2, 2);
    expected << 0.25, 0.25, 0.25, 0.5;
    EXPECT_LT((solve(m, q).s - expected).cwiseAbs().maxCoeff(), 1e-15);  // rounding
}

TEST(Lyapunov, a_growing_mode_is_returned_and_nothing_is_written) {
    Matrix m = decaying(3);
    m.diagonal().array() += 40.0;
    const auto [growth, s] = solve(m, covariance(3));
    EXPECT_GT(growth, 0.0);
    EXPECT_EQ(s, Matrix::Zero(3, 3));
}

TEST(Lyapunov, a_real_matrix_has_the_stationary_covariance_of_its_block) {
    Block m(4), q(4);
    Matrix complex_m(4, 4), complex_q(4, 4);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            m(i, j) = i == j ? -9.0 - i : std::cos(2.0 * i + j);
            q(i, j) = i == j ? 1.0 + i : 0.1;
            complex_m(i, j) = m(i, j);
            complex_q(i, j) = q(i, j);
        }
    const Block expected = stationary_covariance(m, q);
    const Matrix s = solve(complex_m, complex_q).s;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) EXPECT_NEAR(std::abs(s(i, j) - expected(i, j)), 0.0, 1e-15);  // rounding
}

}  // namespace
}  // namespace drover::numerics::lyapunov_tests
