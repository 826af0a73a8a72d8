// numerics/algebra/dense.cpp: by Eigen's decompositions.
#include "numerics/algebra/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "drover/base/error.hpp"

namespace drover::numerics {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

MatrixXcd solution(const MatrixXcd& a, const MatrixXcd& b) { return a.partialPivLu().solve(b); }
MatrixXd inverse(const MatrixXd& a) { return a.partialPivLu().inverse(); }
MatrixXcd inverse(const MatrixXcd& a) { return a.partialPivLu().inverse(); }

MatrixXcd exponential(const MatrixXcd& given) {
    const Eigen::VectorXd scale = balance(given);
    const MatrixXcd a = scale.cwiseInverse().asDiagonal() * given * scale.asDiagonal();
    // 15 terms are exact to rounding where the norm is 1/2 at most.
    const double norm = 2.0 * a.cwiseAbs().rowwise().sum().maxCoeff();
    const int squarings = norm > 1.0 && std::isfinite(norm) ? static_cast<int>(std::ceil(std::log2(norm))) : 0;
    const MatrixXcd part = std::ldexp(1.0, -squarings) * a, one = MatrixXcd::Identity(a.rows(), a.cols());
    MatrixXcd sum = one;
    for (int k = 14; k > 0; --k) sum = one + MatrixXcd(part.lazyProduct(sum)) / k;
    for (int k = 0; k < squarings; ++k) sum = MatrixXcd(sum.lazyProduct(sum));
    return scale.asDiagonal() * sum * scale.cwiseInverse().asDiagonal();
}

/// By the roots of the largest element, of each row and of each column in turn.
Scales even_scales(const MatrixXcd& a) {
    Eigen::ArrayXXd size = a.cwiseAbs();
    Scales result{.rows = Eigen::VectorXd::Ones(a.rows()), .columns = Eigen::VectorXd::Ones(a.cols())};
    const auto power = [](double largest) {
        return largest > 0.0 && std::isfinite(largest) ? std::exp2(-std::round(0.5 * std::log2(largest))) : 1.0;
    };
    constexpr int rounds = 8;  // each halves the exponents
    bool changes = a.size() > 0;
    for (int round = 0; changes && round < rounds; ++round) {
        changes = false;
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
            const double factor = power(size.row(i).maxCoeff());
            size.row(i) *= factor, result.rows(i) *= factor;
            changes = changes || factor != 1.0;
        }
        for (Eigen::Index k = 0; k < a.cols(); ++k) {
            const double factor = power(size.col(k).maxCoeff());
            size.col(k) *= factor, result.columns(k) *= factor;
            changes = changes || factor != 1.0;
        }
    }
    return result;
}

namespace {
/// rows a columns.
template <class Matrix>
Matrix scaled(const Matrix& a, const Scales& by) {
    return by.rows.asDiagonal() * a * by.columns.asDiagonal();
}

template <class Matrix>
bool is_invertible_matrix(const Matrix& a) {
    return scaled(a, even_scales(a.template cast<std::complex<double>>())).fullPivLu().isInvertible();
}

template <class Matrix>
Matrix shortest_even_solution(const Matrix& a, const Matrix& b) {
    const Scales scales = even_scales(a.template cast<std::complex<double>>());
    const Matrix right = scales.rows.asDiagonal() * b;
    return scales.columns.asDiagonal() * Matrix(scaled(a, scales).completeOrthogonalDecomposition().solve(right));
}

template <class Matrix>
DenseEigen eigen_of(const Matrix& a) {
    const Eigen::ComplexEigenSolver<Matrix> solver(a);
    if (solver.info() != Eigen::Success) return {.values = {}, .vectors = {}, .has_converged = false};
    return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

template <class Solver>
VectorXcd eigenvalues_of(const typename Solver::MatrixType& a) {
    return Solver(a, false).eigenvalues();
}

template <class Matrix>
Matrix balanced_of(const Matrix& a) {
    const Eigen::VectorXd scale = balance(a.template cast<std::complex<double>>());
    return scale.cwiseInverse().asDiagonal() * a * scale.asDiagonal();
}

template <class Matrix>
DenseSvd<Matrix> svd_of(const Matrix& a) {
    const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return {.left = svd.matrixU(), .values = svd.singularValues(), .right = svd.matrixV()};
}

template <class Matrix>
double solve_lyapunov_as(const Matrix& m, const Matrix& q, MatrixXcd& s) {
    const Eigen::ComplexSchur<Matrix> schur(m);
    Matrix solution;
    const double largest = solve_lyapunov_of_schur<Matrix>(schur.matrixT(), schur.matrixU(), q, solution);
    if (largest < 0.0) s = solution;
    return largest;
}
}  // namespace

MatrixXd pivoted_inverse(const MatrixXd& a) {
    const Scales scales = even_scales(a.cast<std::complex<double>>());
    const MatrixXd even = scaled(a, scales).fullPivLu().inverse();
    return scales.columns.asDiagonal() * even * scales.rows.asDiagonal();
}

bool is_invertible(const MatrixXd& a) { return is_invertible_matrix(a); }
bool is_invertible(const MatrixXcd& a) { return is_invertible_matrix(a); }

MatrixXd shortest_solution(const MatrixXd& a, const MatrixXd& b, double threshold) {
    if (threshold == 0.0) return shortest_even_solution(a, b);
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    return solver.setThreshold(threshold).compute(a).solve(b);
}

MatrixXcd shortest_solution(const MatrixXcd& a, const MatrixXcd& b) { return shortest_even_solution(a, b); }

MatrixXd orthogonal_factor(const MatrixXd& a) { return Eigen::HouseholderQR<MatrixXd>(a).householderQ(); }

Eigen::VectorXd balance(const Eigen::MatrixXcd& a) {
    if (a.rows() == 0) return {};
    Eigen::ArrayXXd size = a.real().array().abs() + a.imag().array().abs();
    const double largest = size.matrix().diagonal().maxCoeff();
    size.matrix().diagonal().setZero();
    Eigen::VectorXd result = Eigen::VectorXd::Ones(a.rows());
    constexpr int max_sweeps = 64;
    bool changes = true;
    for (int sweep = 0; changes && sweep < max_sweeps; ++sweep) {
        changes = false;
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
            const double row = size.row(i).sum(), column = size.col(i).sum();
            double squared = row / column;
            if (!(row > 0.0)) squared = std::min(1.0, std::pow(largest / column, 2));
            else if (!(column > 0.0)) squared = std::max(1.0, std::pow(row / largest, 2));
            if (!(squared > 0.0) || !std::isfinite(squared) || (squared > 0.25 && squared < 4.0)) continue;
            const double factor = std::exp2(std::round(0.5 * std::log2(squared)));
            if (column * factor + row / factor > 0.95 * (column + row)) continue;
            result(i) *= factor;
            size.row(i) /= factor;
            size.col(i) *= factor;
            changes = true;
        }
    }
    return result;
}

MatrixXd balanced(const MatrixXd& a) { return balanced_of(a); }
MatrixXcd balanced(const MatrixXcd& a) { return balanced_of(a); }

DenseEigen dense_eigen(const MatrixXcd& a) {
    return a.rows() <= max_small_rows ? eigen_of<SmallSquare<std::complex<double>>>(a) : eigen_of(a);
}

VectorXcd dense_eigenvalues(const MatrixXcd& a) {
    return a.rows() <= max_small_rows ? eigenvalues_of<Eigen::ComplexEigenSolver<SmallSquare<std::complex<double>>>>(a)
                                      : eigenvalues_of<Eigen::ComplexEigenSolver<MatrixXcd>>(a);
}
VectorXcd dense_eigenvalues(const MatrixXd& a) { return eigenvalues_of<Eigen::EigenSolver<MatrixXd>>(a); }

DenseSvd<MatrixXd> dense_svd(const MatrixXd& a) { return svd_of(a); }
DenseSvd<MatrixXcd> dense_svd(const MatrixXcd& a) { return svd_of(a); }

double solve_lyapunov(const MatrixXcd& m, const MatrixXcd& q, MatrixXcd& s) {
    require(m.rows() >= 1 && m.rows() <= max_lyapunov && m.cols() == m.rows() && q.rows() == m.rows() &&
                q.cols() == m.rows(),
            {}, "a Lyapunov equation has {} rows; expected 1 to {}", m.rows(), max_lyapunov);
    return m.rows() <= max_small_rows ? solve_lyapunov_as<SmallSquare<std::complex<double>>>(m, q, s)
                                      : solve_lyapunov_as<MatrixXcd>(m, q, s);
}

}  // namespace drover::numerics
