// numerics/isotropic.hpp: isotropic blocks on the modes of a grid: Cartesian components to parts along and across q.
#pragma once
#include <cstddef>
#include <cstring>
#include <vector>

#include "drover/numerics/system.hpp"
#include "drover/numerics/wavenumbers.hpp"

namespace drover::numerics {

/// Unit vector along q; x at q = 0.
struct Direction {
    double x = 1.0, y = 0.0;
    bool turned = false;  ///< q != 0: the vector parts carry the factor i
};

inline Direction direction(const Wavevector& q, double inverse_length) {
    if (inverse_length == 0.0) return {};
    return {.x = q.x * inverse_length, .y = q.y * inverse_length, .turned = true};
}

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
/// The y component of the directions of the modes.
template <class Number>
Number y_of(const Direction& d) {
    if constexpr (sizeof(Number) == sizeof(Pair)) return Pair{d.y, d.y};
    else return Quad{d.y, d.y, -d.y, -d.y};
}

/// Modes of Scalars scalars and Vectors vectors in the variables of IsotropicBlocks.
template <int Scalars, int Vectors, class Number = Pair>
struct ModeParts {
    Number along[Scalars + Vectors] = {};
    Number across[Vectors == 0 ? 1 : Vectors] = {};
};

/// Components of modes in memory: the first, the distance between components, and that of the second row.
template <class Value>
struct ModePlace {
    Value* values = nullptr;
    std::size_t stride = 0;
    std::ptrdiff_t apart = 0;
};

/// Parts of the modes at `from`.
template <int Scalars, int Vectors, class Number = Pair>
[[gnu::always_inline]] inline ModeParts<Scalars, Vectors, Number> parts_of(const ModePlace<const Complex>& from,
                                                                           const Direction& d) {
    ModeParts<Scalars, Vectors, Number> parts;
    const auto component = [&](std::size_t c) { return load_modes<Number>(from.values + c * from.stride, from.apart); };
    const Number d_y = y_of<Number>(d);
    for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) parts.along[s] = component(s);
    for (std::size_t v = 0; v < std::size_t{Vectors}; ++v) {
        const Number x = component(Scalars + 2 * v), y = component(Scalars + 2 * v + 1);
        const Number along = d.x * x + d_y * y, across = d.x * y - d_y * x;
        parts.along[Scalars + v] = d.turned ? times_i(along) : along;
        parts.across[v] = d.turned ? times_i(across) : across;
    }
    return parts;
}

/// to = base + the inverse of parts_of; without base: the inverse alone.
template <int Scalars, int Vectors, class Number>
[[gnu::always_inline]] inline void write_parts(const ModeParts<Scalars, Vectors, Number>& parts, const Complex* base,
                                               const ModePlace<Complex>& to, const Direction& d) {
    const auto write = [&](std::size_t component, const Number& part) {
        const std::size_t at = component * to.stride;
        store_modes<Number>(base ? load_modes<Number>(base + at, to.apart) + part : part, to.values + at, to.apart);
    };
    const Number d_y = y_of<Number>(d);
    for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) write(s, parts.along[s]);
    for (std::size_t v = 0; v < std::size_t{Vectors}; ++v) {
        Number along = parts.along[Scalars + v], across = parts.across[v];
        if (d.turned) {
            along = times_minus_i(along);
            across = times_minus_i(across);
        }
        write(Scalars + 2 * v, d.x * along - d_y * across);
        write(Scalars + 2 * v + 1, d_y * along + d.x * across);
    }
}

/// out += matrix * in, the matrix row by row.
template <std::size_t N, class Number>
[[gnu::always_inline]] inline void add_product(const double* matrix, const Number (&in)[N], Number (&out)[N]) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t k = 0; k < N; ++k) out[i] += matrix[i * N + k] * in[k];
}

/// Appends the entries of both blocks.
void append_entries(const IsotropicBlocks& blocks, std::vector<double>& to);

[[noreturn]] void refuse_layout(const Layout& layout);

/// Calls work.template operator()<Scalars, Vectors>() for a layout.
template <class Work>
auto for_layout(const Layout& layout, Work work) {
    switch (10 * layout.scalars + layout.vectors) {
        case 1: return work.template operator()<0, 1>();
        case 2: return work.template operator()<0, 2>();
        case 10: return work.template operator()<1, 0>();
        case 11: return work.template operator()<1, 1>();
        case 12: return work.template operator()<1, 2>();
        case 20: return work.template operator()<2, 0>();
        case 21: return work.template operator()<2, 1>();
        case 22: return work.template operator()<2, 2>();
        default: refuse_layout(layout);
    }
}
}  // namespace drover::numerics
