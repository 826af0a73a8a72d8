// numerics/fields/complex_registers.hpp: complex numbers in vector registers.
#pragma once
#include <cstddef>
#include <cstring>

#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// Complex numbers in a vector register, real part then imaginary part: that of one mode, or of two modes (qx, qy) and
/// (qx, -qy), which have the same matrices.
using Pair [[gnu::vector_size(16)]] = double;
using Quad [[gnu::vector_size(32)]] = double;

template <class Number, class Value>
Number load_as(const Value* from) {
    Number number;
    std::memcpy(&number, reinterpret_cast<const double*>(from), sizeof(number));
    return number;
}
inline Pair load(const Complex* from) { return load_as<Pair>(from); }
inline void store(const Pair& pair, Complex* to) { std::memcpy(reinterpret_cast<double*>(to), &pair, sizeof(pair)); }
inline Quad joined(const Pair& a, const Pair& b) { return Quad{a[0], a[1], b[0], b[1]}; }
inline Pair times_i(const Pair& a) { return Pair{-a[1], a[0]}; }
inline Quad times_i(const Quad& a) { return Quad{-a[1], a[0], -a[3], a[2]}; }
inline Pair times_minus_i(const Pair& a) { return Pair{a[1], -a[0]}; }
inline Quad times_minus_i(const Quad& a) { return Quad{a[1], -a[0], a[3], -a[2]}; }

/// Multiplies the parts of a field by i^power, 0 <= power <= 3; of a bool the compiler knows that it is 0 or 1.
template <class Number>
[[gnu::always_inline]] inline void multiply_by_i(bool power, Number& along, Number& across) {
    if (!power) return;
    along = times_i(along);
    across = times_i(across);
}
template <class Number>
[[gnu::always_inline]] inline void divide_by_i(bool power, Number& along, Number& across) {
    if (!power) return;
    along = times_minus_i(along);
    across = times_minus_i(across);
}
template <class Number>
void multiply_by_i(int power, Number& along, Number& across) {
    multiply_by_i((power & 1) != 0, along, across);
    if ((power & 2) == 0) return;
    along = -along;
    across = -across;
}
template <class Number>
void divide_by_i(int power, Number& along, Number& across) {
    multiply_by_i((4 - power) & 3, along, across);
}

/// Values of one mode, or of the same column of two rows that are `apart`.
template <class Number>
[[gnu::always_inline]] inline Number load_modes(const Complex* from, std::ptrdiff_t apart) {
    if constexpr (sizeof(Number) == sizeof(Pair)) return load(from);
    else return joined(load(from), load(from + apart));
}
template <class Number>
[[gnu::always_inline]] inline void store_modes(const Number& modes, Complex* to, std::ptrdiff_t apart) {
    store(Pair{modes[0], modes[1]}, to);
    if constexpr (sizeof(Number) == sizeof(Quad)) store(Pair{modes[2], modes[3]}, to + apart);
}

}  // namespace drover::numerics
