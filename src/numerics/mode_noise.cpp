// numerics/mode_noise.cpp: Gaussian numbers with a given covariance for each mode of real fields.
#include "mode_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace drover::numerics {

namespace {
/// Where the numbers of a stored mode come from.
struct Draw {
    std::size_t mode = 0;  ///< the mode whose numbers it takes
    bool conjugated = false;
    bool real = false;
};

Draw draw_of(const Grid& grid, std::size_t m) {
    const std::size_t width = columns(grid), column = m % width, row = m / width,
                      rows = static_cast<std::size_t>(grid.ny);
    if (m == 0) return {.mode = 0, .real = true};
    if (column == 0 && 2 * row > rows) return {.mode = (rows - row) * width, .conjugated = true};
    return {.mode = m};
}

/// out = scale * matrix * normal, two normal numbers for each complex one.
template <std::size_t N>
void multiply(const double* matrix, const double* normal, double scale, const Draw& draw, Pair (&out)[N]) {
    const Pair parts{scale, draw.real ? 0.0 : draw.conjugated ? -scale : scale};
    for (std::size_t i = 0; i < N; ++i) {
        Pair sum{};
        for (std::size_t k = 0; k < N; ++k) sum += matrix[i * N + k] * Pair{normal[2 * k], normal[2 * k + 1]};
        out[i] = parts * sum;
    }
}
}  // namespace

void add_mode_noise(const Grid& grid, const Layout& layout, const DistinctWavenumbers& wavenumbers,
                    const std::vector<double>& factors, const RandomKey& key, Threads& threads, Spectra& to) {
    for_layout(layout, [&]<int Scalars, int Vectors>() {
        constexpr std::size_t along = Scalars + Vectors, across = Vectors;
        constexpr std::size_t normals = 2 * (along + across), entries = along * along + across * across;
        const std::size_t width = columns(grid);
        threads.for_chunks(static_cast<std::size_t>(grid.ny), rows_per_chunk(grid),
                           [&](std::size_t begin, std::size_t end) {
                               std::vector<double> of_row(width * normals);
                               std::array<double, normals> of_partner;
                               for (std::size_t j = begin; j < end; ++j) {
                                   const std::int32_t* index = wavenumbers.of_mode.data() + j * width;
                                   const auto kept = static_cast<std::size_t>(std::find(index, index + width, -1) -
                                                                              index);  // a row's first columns
                                   fill_normal(key, j * width, normals, std::span(of_row.data(), kept * normals));
                                   for (std::size_t i = 0; i < kept; ++i) {
                                       const std::size_t m = j * width + i, n = static_cast<std::size_t>(index[i]);
                                       const Draw draw = draw_of(grid, m);
                                       const double* normal = of_row.data() + i * normals;
                                       if (draw.conjugated) {
                                           fill_normal(key, draw.mode, normals, of_partner);
                                           normal = of_partner.data();
                                       }
                                       const double scale = std::sqrt((draw.real ? 1.0 : 0.5) / area(grid));
                                       const double* factor = factors.data() + n * entries;
                                       ModeParts<Scalars, Vectors> parts;
                                       multiply(factor, normal, scale, draw, parts.along);
                                       multiply(factor + along * along, normal + 2 * along, scale, draw, parts.across);
                                       add_parts(parts, to.values.data(), to.stride, m,
                                                 direction(wavevector(grid, i, j), wavenumbers.inverse[n]));
                                   }
                               }
                           });
    });
}

}  // namespace drover::numerics
