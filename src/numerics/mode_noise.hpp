// numerics/mode_noise.hpp: Gaussian numbers with a given covariance for each mode of real fields.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "isotropic.hpp"

namespace drover::numerics {

/// One draw of noise for every kept mode: Gaussian numbers of covariance f f^T / area, with f from `factors`: for each
/// distinct |q| the entries of its block along q, then of that across.  Real fields: a stored mode whose conjugate is
/// stored too uses the numbers of its partner.
struct NoiseDraw {
    const Grid& grid;
    const DistinctWavenumbers& wavenumbers;
    const std::vector<double>& factors;
    RandomKey key;
};

/// Adds it to all modes of `to`.
void add_mode_noise(const NoiseDraw& draw, const Layout& layout, Threads& threads, Spectra& to);

/// out = scale * matrix * normal, two normal numbers for each complex one.
template <std::size_t N>
[[gnu::always_inline]] inline void noise_of(const double* matrix, const double* normal, const Pair& scale,
                                            Pair (&out)[N]) {
    for (std::size_t i = 0; i < N; ++i) {
        Pair sum{};
        for (std::size_t k = 0; k < N; ++k) sum += matrix[i * N + k] * Pair{normal[2 * k], normal[2 * k + 1]};
        out[i] = scale * sum;
    }
}

/// Adds it to the first `kept` modes of a row, whose components start at `to`, `stride` apart.  normal: scratch,
/// resized as needed.
template <int Scalars, int Vectors>
void add_row_noise(const NoiseDraw& draw, std::size_t row, std::size_t kept, std::vector<double>& normal, Complex* to,
                   std::size_t stride) {
    constexpr std::size_t along = Scalars + Vectors, across = Vectors;
    constexpr std::size_t normals = 2 * (along + across), entries = along * along + across * across;
    const std::size_t width = columns(draw.grid), rows = static_cast<std::size_t>(draw.grid.ny);
    const double half = std::sqrt(0.5 / area(draw.grid)), whole = std::sqrt(1.0 / area(draw.grid));
    normal.resize(std::max(normal.size(), width * normals));
    fill_normal(draw.key, row * width, normals, std::span(normal.data(), kept * normals));
    // The conjugate of a mode of column 0 is stored too: it uses the numbers of its partner.
    const bool is_partner = 2 * row > rows;
    if (is_partner && kept > 0) fill_normal(draw.key, (rows - row) * width, normals, std::span(normal.data(), normals));
    for (std::size_t i = 0; i < kept; ++i) {
        const Pair scale = i > 0      ? Pair{half, half}
                           : row == 0 ? Pair{whole, 0.0}
                                      : Pair{half, is_partner ? -half : half};
        const auto n = static_cast<std::size_t>(draw.wavenumbers.of_mode[row * width + i]);
        const double* factor = draw.factors.data() + n * entries;
        ModeParts<Scalars, Vectors> parts;
        noise_of(factor, normal.data() + i * normals, scale, parts.along);
        noise_of(factor + along * along, normal.data() + i * normals + 2 * along, scale, parts.across);
        add_parts(parts, to, stride, i, direction(wavevector(draw.grid, i, row), draw.wavenumbers.inverse[n]));
    }
}

/// Number of kept modes of a row, which are its first ones.
inline std::size_t kept_in_row(const Grid& grid, const DistinctWavenumbers& wavenumbers, std::size_t row) {
    const std::int32_t* index = wavenumbers.of_mode.data() + row * columns(grid);
    return static_cast<std::size_t>(std::find(index, index + columns(grid), -1) - index);
}

/// Rows of modes in one task of a thread.
inline std::size_t rows_per_chunk(const Grid& grid) {
    constexpr std::size_t modes_at_a_time = 1024;
    return std::max<std::size_t>(1, modes_at_a_time / columns(grid));
}

}  // namespace drover::numerics
