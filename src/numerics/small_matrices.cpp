// numerics/small_matrices.cpp: the instantiations of Eigen's decompositions.
#include "numerics/small_matrices.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "numerics/precise_eigenvalues.hpp"

namespace drover::numerics {

EigenDecomposition eigen_decomposition(const SmallMatrix& m) {
    const Eigen::ComplexEigenSolver<SmallMatrix> solver(m);
    if (loses_slow_modes(m, solver.eigenvalues())) return precise_eigen_decomposition(m);
    return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

SmallVector eigenvalues(const SmallMatrix& m) {
    const SmallVector values = Eigen::ComplexEigenSolver<SmallMatrix>(m, false).eigenvalues();
    return loses_slow_modes(m, values) ? precise_eigen_decomposition(m).values : values;
}

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

}  // namespace drover::numerics
