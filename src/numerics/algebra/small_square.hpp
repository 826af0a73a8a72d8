// numerics/algebra/small_square.hpp: square matrices of at most 6 rows, which need no memory from the heap.
#pragma once
#include <Eigen/Core>

namespace drover::numerics {

inline constexpr int max_small_rows = 6;
template <class Scalar>
using SmallSquare = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, 0, max_small_rows, max_small_rows>;

}  // namespace drover::numerics
