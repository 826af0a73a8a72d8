// numerics/algebra/small_matrices.hpp: decompositions of matrices of at most 6 rows, which need no memory from the
// heap.
#pragma once
#include <Eigen/Core>
#include <complex>

#include "numerics/algebra/small_square.hpp"

namespace drover::numerics {

using SmallMatrix = SmallSquare<std::complex<double>>;
using SmallRealMatrix = SmallSquare<double>;
using SmallVector = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, 1, 0, max_small_rows, 1>;
using SmallRealVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_small_rows, 1>;

/// m vectors = vectors diag(values); columns of norm 1.
struct EigenDecomposition {
    SmallVector values;
    SmallMatrix vectors;
};
EigenDecomposition eigen_decomposition(const SmallMatrix& m);
SmallVector eigenvalues(const SmallMatrix& m);

/// By LU with partial pivoting; m must be regular.
SmallMatrix inverse(const SmallMatrix& m);
SmallRealMatrix real_inverse(const SmallRealMatrix& m);

}  // namespace drover::numerics
