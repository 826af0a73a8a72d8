// numerics/algebra/small_matrices.cpp: as those of any size.
#include "numerics/algebra/small_matrices.hpp"

#include "numerics/algebra/dense.hpp"

namespace drover::numerics {

EigenDecomposition eigen_decomposition(const SmallMatrix& m) {
    const DenseEigen found = dense_eigen(m);
    return {.values = found.values, .vectors = found.vectors};
}

SmallVector eigenvalues(const SmallMatrix& m) { return dense_eigenvalues(Eigen::MatrixXcd(m)); }

SmallMatrix inverse(const SmallMatrix& m) { return inverse(Eigen::MatrixXcd(m)); }
SmallRealMatrix real_inverse(const SmallRealMatrix& m) { return inverse(Eigen::MatrixXd(m)); }

}  // namespace drover::numerics
