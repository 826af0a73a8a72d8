// numerics/isotropic.hpp: isotropic blocks on the modes of a grid: Cartesian components to parts along and across q.
#pragma once
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

/// A complex number as a vector register: real part, imaginary part.
using Pair [[gnu::vector_size(16)]] = double;
inline Pair load(const Complex* from) {
    Pair pair;
    std::memcpy(&pair, reinterpret_cast<const double*>(from), sizeof(pair));
    return pair;
}
inline void store(const Pair& pair, Complex* to) { std::memcpy(reinterpret_cast<double*>(to), &pair, sizeof(pair)); }
inline Pair times_i(const Pair& a) { return Pair{-a[1], a[0]}; }
inline Pair times_minus_i(const Pair& a) { return Pair{a[1], -a[0]}; }

/// One mode of Scalars scalars and Vectors vectors in the variables of IsotropicBlocks.
template <int Scalars, int Vectors>
struct ModeParts {
    Pair along[Scalars + Vectors] = {};
    Pair across[Vectors == 0 ? 1 : Vectors] = {};
};

/// Parts of the mode at place `m`, the components being `stride` apart.
template <int Scalars, int Vectors>
[[gnu::always_inline]] inline ModeParts<Scalars, Vectors> parts_of(const Complex* values, std::size_t stride,
                                                                   std::size_t m, const Direction& d) {
    ModeParts<Scalars, Vectors> parts;
    for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) parts.along[s] = load(values + s * stride + m);
    for (std::size_t v = 0; v < std::size_t{Vectors}; ++v) {
        const Pair x = load(values + (Scalars + 2 * v) * stride + m),
                   y = load(values + (Scalars + 2 * v + 1) * stride + m);
        const Pair along = d.x * x + d.y * y, across = d.x * y - d.y * x;
        parts.along[Scalars + v] = d.turned ? times_i(along) : along;
        parts.across[v] = d.turned ? times_i(across) : across;
    }
    return parts;
}

/// Adds the inverse of parts_of.
template <int Scalars, int Vectors>
[[gnu::always_inline]] inline void add_parts(const ModeParts<Scalars, Vectors>& parts, Complex* values,
                                             std::size_t stride, std::size_t m, const Direction& d) {
    const auto add = [&](std::size_t component, const Pair& part) {
        Complex* to = values + component * stride + m;
        store(load(to) + part, to);
    };
    for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) add(s, parts.along[s]);
    for (std::size_t v = 0; v < std::size_t{Vectors}; ++v) {
        Pair along = parts.along[Scalars + v], across = parts.across[v];
        if (d.turned) {
            along = times_minus_i(along);
            across = times_minus_i(across);
        }
        add(Scalars + 2 * v, d.x * along - d.y * across);
        add(Scalars + 2 * v + 1, d.y * along + d.x * across);
    }
}

/// out += matrix * in, the matrix row by row.
template <std::size_t N>
[[gnu::always_inline]] inline void add_product(const double* matrix, const Pair (&in)[N], Pair (&out)[N]) {
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
