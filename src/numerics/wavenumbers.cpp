// numerics/wavenumbers.cpp: the distinct |q| of a grid.
#include "drover/numerics/wavenumbers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>

namespace drover::numerics {

DistinctWavenumbers distinct_wavenumbers(const Grid& grid, int degree) {
    // Integers distinguish equal |q| from nearly equal ones: k^2 in a square, the pair |kx|, |ky| in a rectangle.
    const bool square = grid.lx == grid.ly;
    const auto key = [&](std::size_t column, std::size_t row) {
        const auto kx = static_cast<std::int64_t>(column),
                   ky = static_cast<std::int64_t>(std::abs(mode_number_y(grid, row)));
        return square ? std::pair<std::int64_t, std::int64_t>{kx * kx + ky * ky, 0} : std::pair{kx, ky};
    };
    struct Entry {
        double q = 0.0;
        std::int32_t index = 0;
    };
    std::map<std::pair<std::int64_t, std::int64_t>, Entry> known;
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i)
            if (is_kept(grid, degree, i, j)) {
                const auto name = key(i, j);
                const Wavevector q = wavevector(grid, i, j);
                // In a square by k^2, not by one of its modes: the same number on every grid of the same cell.
                known.try_emplace(name, Entry{.q = square ? 2.0 * std::numbers::pi / grid.lx *
                                                                std::sqrt(static_cast<double>(name.first))
                                                          : std::hypot(q.x, q.y)});
            }
    DistinctWavenumbers result;
    for (const auto& [name, entry] : known) result.q.push_back(entry.q);
    std::sort(result.q.begin(), result.q.end());
    for (auto& [name, entry] : known)
        entry.index =
            static_cast<std::int32_t>(std::lower_bound(result.q.begin(), result.q.end(), entry.q) - result.q.begin());
    for (const double q : result.q) result.inverse.push_back(q == 0.0 ? 0.0 : 1.0 / q);
    result.of_mode.reserve(modes(grid));
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i)
            result.of_mode.push_back(is_kept(grid, degree, i, j) ? known.at(key(i, j)).index : -1);
    return result;
}

}  // namespace drover::numerics
