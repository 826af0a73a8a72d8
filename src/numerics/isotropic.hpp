// numerics/isotropic.hpp: how isotropic blocks act on the modes of a grid: the change between Cartesian components and the parts
// along and across q.
#pragma once
#include <array>
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

/// One mode of Scalars scalars and Vectors vectors in the variables of IsotropicBlocks.
template <int Scalars, int Vectors>
struct ModeParts {
    std::array<Complex, Scalars + Vectors> along;
    std::array<Complex, Vectors> across;
};

inline Complex times_i(Complex a) { return {-a.imag(), a.real()}; }
inline Complex times_minus_i(Complex a) { return {a.imag(), -a.real()}; }

/// Parts of the mode at place `m`, the components being `stride` apart.
template <int Scalars, int Vectors>
ModeParts<Scalars, Vectors> parts_of(const Complex* values, std::size_t stride, std::size_t m, const Direction& d) {
    ModeParts<Scalars, Vectors> parts;
    for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) parts.along[s] = values[s * stride + m];
    for (std::size_t v = 0; v < std::size_t{Vectors}; ++v) {
        const Complex x = values[(Scalars + 2 * v) * stride + m], y = values[(Scalars + 2 * v + 1) * stride + m];
        const Complex along = d.x * x + d.y * y, across = d.x * y - d.y * x;
        parts.along[Scalars + v] = d.turned ? times_i(along) : along;
        parts.across[v] = d.turned ? times_i(across) : across;
    }
    return parts;
}

/// The inverse of parts_of, added to what is there.
template <int Scalars, int Vectors>
void add_parts(const ModeParts<Scalars, Vectors>& parts, Complex* values, std::size_t stride, std::size_t m,
               const Direction& d) {
    for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) values[s * stride + m] += parts.along[s];
    for (std::size_t v = 0; v < std::size_t{Vectors}; ++v) {
        Complex along = parts.along[Scalars + v], across = parts.across[v];
        if (d.turned) {
            along = times_minus_i(along);
            across = times_minus_i(across);
        }
        values[(Scalars + 2 * v) * stride + m] += d.x * along - d.y * across;
        values[(Scalars + 2 * v + 1) * stride + m] += d.y * along + d.x * across;
    }
}

/// out += matrix * in, the matrix row by row.
template <std::size_t N>
void add_product(const double* matrix, const std::array<Complex, N>& in, std::array<Complex, N>& out) {
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
