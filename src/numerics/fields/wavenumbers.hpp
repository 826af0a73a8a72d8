// numerics/fields/wavenumbers.hpp: the distinct |q| of a grid, for quantities that depend only on |q|.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/grid.hpp"

namespace drover::numerics {

/// The distinct |q| of the kept modes, and the index of that of each stored mode.
struct DistinctWavenumbers {
    std::vector<double> q;              ///< ascending, q[0] = 0 [1/mm]
    std::vector<double> inverse;        ///< 1/q, and 0 for q = 0
    std::vector<std::int32_t> of_mode;  ///< -1: the mode is not kept
};

/// `degree`: as for is_kept.
DistinctWavenumbers distinct_wavenumbers(const Grid& grid, int degree);

/// body(mode, index of its |q|, q) for every kept mode, on any thread.
template <class Body>
void for_kept_modes(const Grid& grid, const DistinctWavenumbers& wavenumbers, Threads& threads, Body body) {
    const std::size_t width = columns(grid);
    threads.for_chunks(static_cast<std::size_t>(grid.ny), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j)
            for (std::size_t i = 0; i < width; ++i) {
                const std::int32_t n = wavenumbers.of_mode[j * width + i];
                if (n < 0) break;  // a row's kept modes are its first
                body(j * width + i, static_cast<std::size_t>(n), wavevector(grid, i, j));
            }
    });
}

}  // namespace drover::numerics
