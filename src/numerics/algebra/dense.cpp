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

MatrixXcd exponential(const MatrixXcd& a) {
    // 15 terms are exact to rounding where the norm is 1/2 at most.
    const double norm = 2.0 * a.cwiseAbs().rowwise().sum().maxCoeff();
    const int squarings = norm > 1.0 && std::isfinite(norm) ? static_cast<int>(std::ceil(std::log2(norm))) : 0;
    const MatrixXcd part = std::ldexp(1.0, -squarings) * a, one = MatrixXcd::Identity(a.rows(), a.cols());
    MatrixXcd sum = one;
    for (int k = 14; k > 0; --k) sum = one + MatrixXcd(part.lazyProduct(sum)) / k;
    for (int k = 0; k < squarings; ++k) sum = MatrixXcd(sum.lazyProduct(sum));
    return sum;
}

MatrixXd pivoted_inverse(const MatrixXd& a) { return a.fullPivLu().inverse(); }
MatrixXcd pivoted_inverse(const MatrixXcd& a) { return a.fullPivLu().inverse(); }
bool is_invertible(const MatrixXd& a) { return a.fullPivLu().isInvertible(); }
bool is_invertible(const MatrixXcd& a) { return a.fullPivLu().isInvertible(); }

MatrixXd shortest_solution(const MatrixXd& a, const MatrixXd& b, double threshold) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    if (threshold > 0.0) solver.setThreshold(threshold);
    return solver.compute(a).solve(b);
}

MatrixXcd shortest_solution(const MatrixXcd& a, const MatrixXcd& b) {
    return a.completeOrthogonalDecomposition().solve(b);
}

MatrixXd orthogonal_factor(const MatrixXd& a) { return Eigen::HouseholderQR<MatrixXd>(a).householderQ(); }

namespace {
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
}  // namespace

Eigen::VectorXd balance(const Eigen::MatrixXcd& a) {
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

DenseEigen dense_eigen(const MatrixXcd& a) {
    return a.rows() <= max_small_rows ? eigen_of<SmallSquare<std::complex<double>>>(a) : eigen_of(a);
}

VectorXcd dense_eigenvalues(const MatrixXcd& a) {
    return a.rows() <= max_small_rows ? eigenvalues_of<Eigen::ComplexEigenSolver<SmallSquare<std::complex<double>>>>(a)
                                      : eigenvalues_of<Eigen::ComplexEigenSolver<MatrixXcd>>(a);
}
VectorXcd dense_eigenvalues(const MatrixXd& a) { return eigenvalues_of<Eigen::EigenSolver<MatrixXd>>(a); }

namespace {
template <class Matrix>
DenseSvd<Matrix> svd_of(const Matrix& a) {
    const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return {.left = svd.matrixU(), .values = svd.singularValues(), .right = svd.matrixV()};
}
}  // namespace

DenseSvd<MatrixXd> dense_svd(const MatrixXd& a) { return svd_of(a); }
DenseSvd<MatrixXcd> dense_svd(const MatrixXcd& a) { return svd_of(a); }

namespace {
template <class Matrix>
double solve_lyapunov_as(const Matrix& m, const Matrix& q, MatrixXcd& s) {
    const Eigen::ComplexSchur<Matrix> schur(m);
    Matrix solution;
    const double largest = solve_lyapunov_of_schur<Matrix>(schur.matrixT(), schur.matrixU(), q, solution);
    if (largest < 0.0) s = solution;
    return largest;
}
}  // namespace

double solve_lyapunov(const MatrixXcd& m, const MatrixXcd& q, MatrixXcd& s) {
    require(m.rows() >= 1 && m.rows() <= max_lyapunov && m.cols() == m.rows() && q.rows() == m.rows() &&
                q.cols() == m.rows(),
            {}, "a Lyapunov equation has {} rows; expected 1 to {}", m.rows(), max_lyapunov);
    return m.rows() <= max_small_rows ? solve_lyapunov_as<SmallSquare<std::complex<double>>>(m, q, s)
                                      : solve_lyapunov_as<MatrixXcd>(m, q, s);
}

}  // namespace drover::numerics
