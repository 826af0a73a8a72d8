// base/eigen_templates.hpp: Eigen's product kernels of real and complex matrices, compiled once.
//
// Part of the precompiled header: each source that multiplies matrices would otherwise compile them again.  No source
// needs it.
#pragma once
#include <Eigen/Core>
#include <complex>

// DROVER_EIGEN_TEMPLATE: "extern template" in all sources but eigen_templates.cpp, which compiles them.
#ifndef DROVER_EIGEN_TEMPLATE
#define DROVER_EIGEN_TEMPLATE extern template
#endif

namespace Eigen {

namespace internal {
template <class Scalar, int order>
using Mapped = const_blas_data_mapper<Scalar, Index, order>;
template <class Scalar>
using Written = blas_data_mapper<Scalar, Index, ColMajor, Unaligned, 1>;

#define DROVER_EIGEN_KERNELS(Scalar, conjugate_left, conjugate_right)                                                 \
    DROVER_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, Scalar, Mapped<Scalar, ColMajor>, ColMajor,     \
                                                               conjugate_left, Scalar, Mapped<Scalar, ColMajor>,      \
                                                               conjugate_right>;                                      \
    DROVER_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, Scalar, Mapped<Scalar, ColMajor>, ColMajor,     \
                                                               conjugate_left, Scalar, Mapped<Scalar, RowMajor>,      \
                                                               conjugate_right>;                                      \
    DROVER_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, Scalar, Mapped<Scalar, RowMajor>, RowMajor,     \
                                                               conjugate_left, Scalar, Mapped<Scalar, ColMajor>,      \
                                                               conjugate_right>;                                      \
    DROVER_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, Scalar, Mapped<Scalar, RowMajor>, RowMajor,     \
                                                               conjugate_left, Scalar, Mapped<Scalar, RowMajor>,      \
                                                               conjugate_right, BuiltIn>;                             \
    DROVER_EIGEN_TEMPLATE struct gebp_kernel<Scalar, Scalar, Index, Written<Scalar>, gebp_traits<Scalar, Scalar>::mr, \
                                             gebp_traits<Scalar, Scalar>::nr, conjugate_left, conjugate_right>
DROVER_EIGEN_KERNELS(double, false, false);
DROVER_EIGEN_KERNELS(std::complex<double>, false, false);
DROVER_EIGEN_KERNELS(std::complex<double>, false, true);
DROVER_EIGEN_KERNELS(std::complex<double>, true, false);
#undef DROVER_EIGEN_KERNELS
}  // namespace internal

}  // namespace Eigen
