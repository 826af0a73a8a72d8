// numerics/small_matrices.cpp: the instantiations of Eigen's decompositions.
#include "numerics/small_matrices.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace drover::numerics {

EigenDecomposition eigen_decomposition(const SmallMatrix& m) {
    const Eigen::ComplexEigenSolver<SmallMatrix> solver(m);
    return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

SmallVector eigenvalues(const SmallMatrix& m) { return Eigen::ComplexEigenSolver<SmallMatrix>(m, false).eigenvalues(); }

SmallVector eigenvalues(const SmallRealMatrix& m) {
    return Eigen::EigenSolver<SmallRealMatrix>(m, false).eigenvalues();
}

SchurDecomposition schur_decomposition(const SmallMatrix& m) {
    const Eigen::ComplexSchur<SmallMatrix> schur(m);
    return {.triangular = schur.matrixT(), .unitary = schur.matrixU()};
}

SingularValueDecomposition singular_value_decomposition(const SmallMatrix& m) {
    const Eigen::JacobiSVD<SmallMatrix> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return {.left = svd.matrixU(), .values = svd.singularValues(), .right = svd.matrixV()};
}

SmallMatrix inverse(const SmallMatrix& m) { return m.partialPivLu().inverse(); }
SmallRealMatrix real_inverse(const SmallRealMatrix& m) { return m.partialPivLu().inverse(); }

}  // namespace drover::numerics
