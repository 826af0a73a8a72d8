// numerics/algebra/lyapunov_solver.hpp: the Lyapunov equation in either precision.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <complex>

namespace drover::numerics {

/// As solve_lyapunov, of m = u t u^H with a triangular t and a unitary u.  Matrix: square, complex.
template <class Matrix>
typename Matrix::RealScalar solve_lyapunov(const Matrix& t, const Matrix& u, const Matrix& q, Matrix& s) {
    using Complex = typename Matrix::Scalar;
    using Real = typename Matrix::RealScalar;
    const Eigen::Index n = t.rows();
    Real largest = t(0, 0).real();
    for (Eigen::Index i = 1; i < n; ++i)
        if (!(t(i, i).real() <= largest)) largest = t(i, i).real();
    if (!(largest < Real(0))) return largest;
    Matrix y = u.adjoint() * q * u;
    for (Eigen::Index j = n; j-- > 0;)
        for (Eigen::Index i = n; i-- > 0;) {
            Complex sum = y(i, j);
            for (Eigen::Index k = i + 1; k < n; ++k) sum += t(i, k) * y(k, j);
            for (Eigen::Index k = j + 1; k < n; ++k) sum += y(i, k) * std::conj(t(j, k));
            y(i, j) = -sum / (t(i, i) + std::conj(t(j, j)));
        }
    const Matrix product = u * y * u.adjoint();
    s = Real(0.5) * (product + product.adjoint());
    return largest;
}

}  // namespace drover::numerics
