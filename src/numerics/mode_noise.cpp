// numerics/mode_noise.cpp: Gaussian numbers with a given covariance for each mode of real fields.
#include "mode_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace drover::numerics {

namespace {
/// out = scale * matrix * normal, two normal numbers for each complex one.
template <std::size_t N>
void multiply(const double* matrix, const double* normal, const Pair& scale, Pair (&out)[N]) {
    for (std::size_t i = 0; i < N; ++i) {
        Pair sum{};
        for (std::size_t k = 0; k < N; ++k) sum += matrix[i * N + k] * Pair{normal[2 * k], normal[2 * k + 1]};
        out[i] = scale * sum;
    }
}
}  // namespace

void add_mode_noise(const Grid& grid, const Layout& layout, const DistinctWavenumbers& wavenumbers,
                    const std::vector<double>& factors, const RandomKey& key, Threads& threads, Spectra& to) {
    for_layout(layout, [&]<int Scalars, int Vectors>() {
        constexpr std::size_t along = Scalars + Vectors, across = Vectors;
        constexpr std::size_t normals = 2 * (along + across), entries = along * along + across * across;
        const std::size_t width = columns(grid);
        const std::size_t rows = static_cast<std::size_t>(grid.ny);
        const double half = std::sqrt(0.5 / area(grid)), whole = std::sqrt(1.0 / area(grid));
        threads.for_chunks(rows, rows_per_chunk(grid), [&](std::size_t begin, std::size_t end) {
            std::vector<double> normal(width * normals);
            for (std::size_t j = begin; j < end; ++j) {
                const std::int32_t* index = wavenumbers.of_mode.data() + j * width;
                const auto kept = static_cast<std::size_t>(std::find(index, index + width, -1) - index);
                fill_normal(key, j * width, normals, std::span(normal.data(), kept * normals));
                // The conjugate of a mode of column 0 is stored too: it takes the numbers of its partner.
                const bool is_partner = 2 * j > rows;
                if (is_partner && kept > 0)
                    fill_normal(key, (rows - j) * width, normals, std::span(normal.data(), normals));
                for (std::size_t i = 0; i < kept; ++i) {
                    const Pair scale = i > 0    ? Pair{half, half}
                                       : j == 0 ? Pair{whole, 0.0}
                                                : Pair{half, is_partner ? -half : half};
                    const auto n = static_cast<std::size_t>(index[i]);
                    const double* factor = factors.data() + n * entries;
                    ModeParts<Scalars, Vectors> parts;
                    multiply(factor, normal.data() + i * normals, scale, parts.along);
                    multiply(factor + along * along, normal.data() + i * normals + 2 * along, scale, parts.across);
                    add_parts(parts, to.values.data(), to.stride, j * width + i,
                              direction(wavevector(grid, i, j), wavenumbers.inverse[n]));
                }
            }
        });
    });
}

}  // namespace drover::numerics
