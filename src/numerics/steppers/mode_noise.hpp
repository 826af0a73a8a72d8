// numerics/steppers/mode_noise.hpp: Gaussian numbers for each mode of real fields, and the parts of one mode.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "numerics/steppers/isotropic.hpp"

namespace drover::numerics {

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

/// Normal numbers of covariance 1/area, `parts` complex ones for each of the first `kept` modes of a row.  Those of a
/// mode are a function of the key and its signed wavevector (kx, ky) alone: grids of N and 2N points share them.  Their
/// order is that of the parts: the even ones, then the odd ones, each in the order of the fields (block_parts); two
/// numbers for each, its real and its imaginary part.
inline void fill_row_normals(const Grid& grid, const RandomKey& key, std::size_t row, std::size_t kept,
                             std::size_t parts, std::vector<double>& normal) {
    const int ky = mode_number_y(grid, row);
    const auto first = [](int number) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(number)) << 32; };
    normal.resize(std::max(normal.size(), kept * 2 * parts));
    if (kept == 0) return;
    fill_normal(key, first(ky), 2 * parts, std::span(normal.data(), kept * 2 * parts));
    // The conjugate of a mode of column 0 is stored too: it uses the numbers of its partner.
    if (ky < 0) fill_normal(key, first(-ky), 2 * parts, std::span(normal.data(), 2 * parts));
    const double half = std::sqrt(0.5 / area(grid));
    for (std::size_t k = 0; k < kept * 2 * parts; ++k) normal[k] *= half;
    for (std::size_t k = 0; k < parts; ++k) {
        if (ky < 0) normal[2 * k + 1] *= -1.0;
        if (ky != 0) continue;
        normal[2 * k] *= std::numbers::sqrt2;  // the mean is real
        normal[2 * k + 1] = 0.0;
    }
}

/// One mode as an array of its parts; of two modes: one of each array.
template <class Number = Pair, class Kernel>
[[gnu::always_inline]] inline ModeParts<Kernel, Number> load_parts(const Kernel& kernel, const double* from,
                                                                   const double* second = nullptr) {
    ModeParts<Kernel, Number> parts;
    for (std::size_t k = 0; k < kernel.parts; ++k)
        if constexpr (sizeof(Number) == sizeof(Pair)) parts.values[k] = load_as<Pair>(from + 2 * k);
        else parts.values[k] = joined(load_as<Pair>(from + 2 * k), load_as<Pair>(second + 2 * k));
    return parts;
}

template <class Kernel>
[[gnu::always_inline]] inline void store_parts(const Kernel& kernel, const ModeParts<Kernel, Pair>& parts, double* to) {
    for (std::size_t k = 0; k < kernel.parts; ++k) std::memcpy(to + 2 * k, &parts.values[k], sizeof(Pair));
}

}  // namespace drover::numerics
