// numerics/fields/paired_rows.hpp: rows of two real fields as rows of one complex field, and their modes as its modes.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "numerics/fields/complex_registers.hpp"

namespace drover::numerics {

inline constexpr std::size_t line_rows = 4;  ///< of one column: a cache line

using Order [[gnu::vector_size(32)]] = std::int64_t;
template <class Value>
Quad load_quad(const Value* from) {
    return load_as<Quad>(from);
}
inline void store_quad(const Quad& quad, double* to) { std::memcpy(to, &quad, sizeof(quad)); }
inline void store_quad(const Quad& quad, Complex* to) { store_quad(quad, reinterpret_cast<double*>(to)); }

inline void split_parts(const Complex* from, std::size_t count, double* real, double* imaginary) {
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4) {
        const Quad a = load_quad(from + i), b = load_quad(from + i + 2);
        store_quad(__builtin_shuffle(a, b, Order{0, 2, 4, 6}), real + i);
        if (imaginary) store_quad(__builtin_shuffle(a, b, Order{1, 3, 5, 7}), imaginary + i);
    }
    for (; i < count; ++i) {
        real[i] = from[i].real();
        if (imaginary) imaginary[i] = from[i].imag();
    }
}
/// The largest parts of numbers, four lanes at a time.
struct Largest {
    Quad of_four{};

    void take(const Quad& values) {
        const Quad size = reinterpret_cast<Quad>(reinterpret_cast<Order>(values) & Order{all, all, all, all});
        of_four = size > of_four ? size : of_four;
    }
    void take(const Pair& values) { take(joined(values, values)); }
    double value() const { return std::max({of_four[0], of_four[1], of_four[2], of_four[3]}); }
    static constexpr std::int64_t all = std::numeric_limits<std::int64_t>::max();  ///< bits but that of the sign
};

/// The power of 2 by which the second of two real fields is multiplied while both are one complex field: the rounding
/// of the larger would drown the smaller.  1 unless their sizes differ by more than some.
inline double scale_of_second(const Largest& first, const Largest& second) {
    constexpr int some = 20, many = 1000;  // powers of 2
    const double a = first.value(), b = second.value();
    if (!(a > 0.0 && b > 0.0 && std::isfinite(a) && std::isfinite(b))) return 1.0;
    const int apart = std::clamp(std::ilogb(a) - std::ilogb(b), -many, many);
    return std::abs(apart) <= some ? 1.0 : std::ldexp(1.0, apart);
}

inline void multiply(double factor, double* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) values[i] *= factor;
}

/// To a + i scale b; returns the scale.  b: nullptr for 0.
inline double join_parts(const double* a, const double* b, std::size_t count, Complex* to) {
    Largest of_a, of_b;
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4) {
        const Quad real = load_quad(a + i), imaginary = b ? load_quad(b + i) : Quad{};
        of_a.take(real);
        of_b.take(imaginary);
        store_quad(__builtin_shuffle(real, imaginary, Order{0, 4, 1, 5}), to + i);
        store_quad(__builtin_shuffle(real, imaginary, Order{2, 6, 3, 7}), to + i + 2);
    }
    for (; i < count; ++i) {
        to[i] = {a[i], b ? b[i] : 0.0};
        of_a.take(Pair{a[i], a[i]});
        of_b.take(Pair{to[i].imag(), to[i].imag()});
    }
    const double scale = scale_of_second(of_a, of_b);
    for (i = 0; i < count && scale != 1.0; ++i) to[i].imag(scale * to[i].imag());
    return scale;
}

/// Calls body(n, j) for n rows at once from row j on: for a cache line of rows, or for each of fewer.
template <class Body>
void in_lines(std::size_t lines, Body body) {
    if (lines == line_rows) return body(std::integral_constant<std::size_t, line_rows>(), std::size_t{0});
    for (std::size_t j = 0; j < lines; ++j) body(std::integral_constant<std::size_t, 1>(), j);
}

/// The modes of rows of a real field, of which a column has consecutive rows, and back.
template <std::size_t Lines>
void spread_modes(const Complex* a, std::size_t pitch, std::size_t kept, std::size_t row, Complex* to) {
    for (std::size_t k = 0; k < kept; ++k)
        for (std::size_t j = 0; j < Lines; ++j) {
            const Complex z = to[j * row + k] = a[k * pitch + j];
            if (k > 0) to[(j + 1) * row - k] = std::conj(z);
        }
}
template <std::size_t Lines>
void collect_modes(const Complex* from, std::size_t row, std::size_t kept, std::size_t pitch, Complex* a) {
    for (std::size_t k = 0; k < kept; ++k)
        for (std::size_t j = 0; j < Lines; ++j) store(load(from + j * row + k), a + k * pitch + j);
}

inline Pair conjugate(const Pair& a) { return Pair{a[0], -a[1]}; }
inline Quad conjugate(const Quad& a) { return Quad{a[0], -a[1], a[2], -a[3]}; }
/// The same mode of as many rows as fit in a register.
template <std::size_t Lines>
using Rows = std::conditional_t<Lines == 1, Pair, Quad>;

/// The modes of two real fields as those of a + i scale b; returns the scale that they need.
template <std::size_t Lines>
[[gnu::always_inline]] inline double join_modes_with(double scale, const Complex* a, const Complex* b,
                                                     std::size_t pitch, std::size_t kept, std::size_t row,
                                                     Complex* to) {
    using Number = Rows<Lines>;
    constexpr std::size_t rows = sizeof(Number) / sizeof(Pair);
    Largest of_a, of_b;
    for (std::size_t j = 0; j < Lines; ++j) {
        to[j * row] = {a[j].real(), scale * b[j].real()};
        of_a.take(load(a + j));
        of_b.take(load(b + j));
    }
    for (std::size_t k = 1; k < kept; ++k)
        for (std::size_t j = 0; j < Lines; j += rows) {
            const auto first = load_as<Number>(a + k * pitch + j), second = load_as<Number>(b + k * pitch + j),
                       turned = scale * times_i(second);
            of_a.take(first);
            of_b.take(second);
            store_modes<Number>(first + turned, to + j * row + k, static_cast<std::ptrdiff_t>(row));
            store_modes<Number>(conjugate(first - turned), to + (j + 1) * row - k, static_cast<std::ptrdiff_t>(row));
        }
    return scale_of_second(of_a, of_b);
}

/// To a + i scale b; returns the scale.
template <std::size_t Lines>
double join_modes(const Complex* a, const Complex* b, std::size_t pitch, std::size_t kept, std::size_t row,
                  Complex* to) {
    const double scale = join_modes_with<Lines>(1.0, a, b, pitch, kept, row, to);
    if (scale != 1.0) join_modes_with<Lines>(scale, a, b, pitch, kept, row, to);
    return scale;
}

/// Back.
template <std::size_t Lines>
void split_modes(const Complex* from, std::size_t row, std::size_t kept, double scale, std::size_t pitch, Complex* a,
                 Complex* b) {
    using Number = Rows<Lines>;
    constexpr std::size_t rows = sizeof(Number) / sizeof(Pair);
    const double half_of_b = 0.5 / scale;
    for (std::size_t j = 0; j < Lines; ++j) {
        a[j] = from[j * row].real();
        b[j] = from[j * row].imag() / scale;
    }
    for (std::size_t k = 1; k < kept; ++k)
        for (std::size_t j = 0; j < Lines; j += rows) {
            const auto z = load_modes<Number>(from + j * row + k, static_cast<std::ptrdiff_t>(row)),
                       w = conjugate(load_modes<Number>(from + (j + 1) * row - k, static_cast<std::ptrdiff_t>(row)));
            const Number of_a = 0.5 * (z + w), of_b = half_of_b * times_minus_i(z - w);
            store_modes(of_a, a + k * pitch + j, 1);
            store_modes(of_b, b + k * pitch + j, 1);
        }
}

}  // namespace drover::numerics
