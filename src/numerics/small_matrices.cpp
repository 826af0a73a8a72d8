// numerics/small_matrices.cpp: the instantiations of Eigen's decompositions.
#include "numerics/small_matrices.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "numerics/dense.hpp"

namespace drover::numerics {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

EigenDecomposition eigen_decomposition(const SmallMatrix& m) {
    const Eigen::ComplexEigenSolver<MatrixXcd> solver(m);
    return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

SmallVector eigenvalues(const SmallMatrix& m) { return Eigen::ComplexEigenSolver<MatrixXcd>(m, false).eigenvalues(); }

SmallVector eigenvalues(const SmallRealMatrix& m) { return Eigen::EigenSolver<MatrixXd>(m, false).eigenvalues(); }

SchurDecomposition schur_decomposition(const SmallMatrix& m) {
    const Eigen::ComplexSchur<MatrixXcd> schur(m);
    return {.triangular = schur.matrixT(), .unitary = schur.matrixU()};
}

SingularValueDecomposition singular_value_decomposition(const SmallMatrix& m) {
    const Eigen::JacobiSVD<MatrixXcd> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return {.left = svd.matrixU(), .values = svd.singularValues(), .right = svd.matrixV()};
}

SmallMatrix inverse(const SmallMatrix& m) { return inverse(MatrixXcd(m)); }
SmallRealMatrix real_inverse(const SmallRealMatrix& m) { return inverse(MatrixXd(m)); }

}  // namespace drover::numerics
