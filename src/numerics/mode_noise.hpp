// numerics/mode_noise.hpp: Gaussian numbers with a given covariance for each mode of real fields.
#pragma once
#include <algorithm>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "isotropic.hpp"

namespace drover::numerics {

/// Adds to `to` for each kept mode a Gaussian number of covariance f f^T / area, with f from `factors`: for each
/// distinct |q| the entries of its block along q, then of that across.  Real fields: a stored mode whose conjugate is stored too
/// repeats the numbers of its partner.
void add_mode_noise(const Grid& grid, const Layout& layout, const DistinctWavenumbers& wavenumbers,
                    const std::vector<double>& factors, const RandomKey& key, Threads& threads, Spectra& to);

/// Rows of modes that one thread takes at a time.
inline std::size_t rows_per_chunk(const Grid& grid) {
    constexpr std::size_t modes_at_a_time = 1024;
    return std::max<std::size_t>(1, modes_at_a_time / columns(grid));
}

}  // namespace drover::numerics
