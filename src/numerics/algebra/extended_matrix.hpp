// numerics/algebra/extended_matrix.hpp: square matrices in extended precision.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace drover::numerics {

using ExtendedReal = long double;  // 64 bits of mantissa on x86-64

/// Count numbers; Count = 0: a count known at run time alone.
template <std::size_t Count>
struct ExtendedNumbers : std::array<ExtendedReal, Count> {
    explicit ExtendedNumbers(std::size_t = 0) : std::array<ExtendedReal, Count>{} {}
};
template <>
struct ExtendedNumbers<0> : std::vector<ExtendedReal> {
    explicit ExtendedNumbers(std::size_t count = 0) : std::vector<ExtendedReal>(count) {}
};

/// Of N rows; N = any_size: of a number known at run time alone, which is several times slower.  Plain loops: unrolled
/// expressions of Eigen take minutes to compile.
inline constexpr int any_size = 0;
template <int N>
struct ExtendedMatrix {
    ExtendedMatrix() : ExtendedMatrix(0) {}
    explicit ExtendedMatrix(int rows)
        : size(rows), values(static_cast<std::size_t>(rows) * static_cast<std::size_t>(rows)) {}
    int rows() const {
        if constexpr (N == any_size) return size;
        else return N;
    }
    ExtendedReal& operator()(int i, int j) { return values[static_cast<std::size_t>(i * rows() + j)]; }
    ExtendedReal operator()(int i, int j) const { return values[static_cast<std::size_t>(i * rows() + j)]; }

    int size;
    ExtendedNumbers<std::size_t{N} * N> values;
};

template <int N>
using ExtendedVector = ExtendedNumbers<std::size_t{N}>;

template <int N>
ExtendedMatrix<N> identity(int rows) {
    ExtendedMatrix<N> result(rows);
    for (int i = 0; i < result.rows(); ++i) result(i, i) = 1.0L;
    return result;
}

template <int N>
ExtendedMatrix<N>& operator+=(ExtendedMatrix<N>& a, const ExtendedMatrix<N>& b) {
    for (std::size_t k = 0; k < a.values.size(); ++k) a.values[k] += b.values[k];
    return a;
}

template <int N>
ExtendedMatrix<N> operator+(ExtendedMatrix<N> a, const ExtendedMatrix<N>& b) {
    return a += b;
}

template <int N>
ExtendedMatrix<N> operator-(ExtendedMatrix<N> a, const ExtendedMatrix<N>& b) {
    for (std::size_t k = 0; k < a.values.size(); ++k) a.values[k] -= b.values[k];
    return a;
}

template <int N>
ExtendedMatrix<N> operator*(ExtendedReal factor, ExtendedMatrix<N> a) {
    for (ExtendedReal& value : a.values) value *= factor;
    return a;
}

template <int N>
ExtendedMatrix<N> operator/(ExtendedMatrix<N> a, ExtendedReal divisor) {
    for (ExtendedReal& value : a.values) value /= divisor;
    return a;
}

template <int N>
ExtendedMatrix<N> operator*(const ExtendedMatrix<N>& a, const ExtendedMatrix<N>& b) {
    ExtendedMatrix<N> result(a.rows());
    for (int i = 0; i < a.rows(); ++i)
        for (int j = 0; j < a.rows(); ++j) {
            ExtendedReal sum = a(i, 0) * b(0, j);
            for (int k = 1; k < a.rows(); ++k) sum += a(i, k) * b(k, j);
            result(i, j) = sum;
        }
    return result;
}

template <int N>
ExtendedMatrix<N> transposed(const ExtendedMatrix<N>& a) {
    ExtendedMatrix<N> result(a.rows());
    for (int i = 0; i < a.rows(); ++i)
        for (int j = 0; j < a.rows(); ++j) result(i, j) = a(j, i);
    return result;
}

template <int N>
ExtendedMatrix<N> symmetric_part(const ExtendedMatrix<N>& a) {
    return (a + transposed(a)) / 2.0L;
}

/// Of the magnitudes; a NaN is not noticed.
template <int N>
ExtendedReal max_abs(const ExtendedMatrix<N>& a) {
    ExtendedReal largest = 0.0L;
    for (const ExtendedReal value : a.values) largest = std::max(largest, std::abs(value));
    return largest;
}

}  // namespace drover::numerics
