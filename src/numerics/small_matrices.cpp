// numerics/small_matrices.cpp: as those of any size.
#include "numerics/small_matrices.hpp"

#include "numerics/dense.hpp"

namespace drover::numerics {

EigenDecomposition eigen_decomposition(const SmallMatrix& m) {
    const DenseEigen found = dense_eigen(m);
    return {.values = found.values, .vectors = found.vectors};
}

SmallVector eigenvalues(const SmallMatrix& m) { return dense_eigenvalues(Eigen::MatrixXcd(m)); }
SmallVector eigenvalues(const SmallRealMatrix& m) { return dense_eigenvalues(Eigen::MatrixXd(m)); }

SchurDecomposition schur_decomposition(const SmallMatrix& m) {
    const DenseSchur found = dense_schur(m);
    return {.triangular = found.triangular, .unitary = found.unitary};
}

SingularValueDecomposition singular_value_decomposition(const SmallMatrix& m) {
    const DenseSvd<Eigen::MatrixXcd> found = dense_svd(Eigen::MatrixXcd(m));
    return {.left = found.left, .values = found.values, .right = found.right};
}

SmallMatrix inverse(const SmallMatrix& m) { return inverse(Eigen::MatrixXcd(m)); }
SmallRealMatrix real_inverse(const SmallRealMatrix& m) { return inverse(Eigen::MatrixXd(m)); }

}  // namespace drover::numerics
