// numerics/extended_matrix.hpp: square matrices of a size known at compile time, in extended precision.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace drover::numerics {

using ExtendedReal = long double;  // 64 bits of mantissa on x86-64

/// Plain loops: unrolled expressions of Eigen take minutes to compile, and those of a size known at run time alone are
/// several times slower.
template <int N>
struct ExtendedMatrix {
    ExtendedReal& operator()(int i, int j) { return values[static_cast<std::size_t>(i * N + j)]; }
    ExtendedReal operator()(int i, int j) const { return values[static_cast<std::size_t>(i * N + j)]; }

    std::array<ExtendedReal, std::size_t{N} * N> values{};
};

template <int N>
using ExtendedVector = std::array<ExtendedReal, std::size_t{N}>;

template <int N>
ExtendedMatrix<N> identity() {
    ExtendedMatrix<N> result;
    for (int i = 0; i < N; ++i) result(i, i) = 1.0L;
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
    ExtendedMatrix<N> result;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) {
            ExtendedReal sum = a(i, 0) * b(0, j);
            for (int k = 1; k < N; ++k) sum += a(i, k) * b(k, j);
            result(i, j) = sum;
        }
    return result;
}

template <int N>
ExtendedMatrix<N> transposed(const ExtendedMatrix<N>& a) {
    ExtendedMatrix<N> result;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) result(i, j) = a(j, i);
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
