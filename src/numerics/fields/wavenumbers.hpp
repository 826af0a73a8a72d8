// numerics/fields/wavenumbers.hpp: the distinct |q| of a grid, for quantities that depend only on |q|.
#pragma once
#include <cstdint>
#include <vector>

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

}  // namespace drover::numerics
