// numerics/fields/wavenumbers.cpp: the distinct |q| of a grid.
#include "numerics/fields/wavenumbers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace drover::numerics {

DistinctWavenumbers distinct_wavenumbers(const Grid& grid, int degree) {
    // Integers distinguish equal |q| from nearly equal ones: k^2 in a square, the pair |kx|, |ky| in a rectangle.  On a
    // line, and on few rows, there are many more numbers up to the largest k^2 than pairs.
    const bool square = grid.lx == grid.ly;
    const std::size_t width = columns(grid), rows = static_cast<std::size_t>(grid.ny);
    const auto ky_of = [&](std::size_t row) { return static_cast<std::size_t>(std::abs(mode_number_y(grid, row))); };
    const auto square_of = [&](std::size_t column, std::size_t row) {
        return column * column + ky_of(row) * ky_of(row);
    };
    const bool by_square = square && square_of(width - 1, rows / 2) <= 4 * modes(grid);
    const auto key = [&](std::size_t column, std::size_t row) {
        return by_square ? square_of(column, row) : column + width * ky_of(row);
    };
    struct Entry {
        double q = 0.0;
        std::size_t key = 0;
    };
    std::vector<Entry> entries;
    std::vector<std::int32_t> index_of(key(width - 1, rows / 2) + 1, -1);  // by key; -1: not met yet
    for (std::size_t j = 0; j <= rows / 2; ++j)
        for (std::size_t i = 0; i < width && is_kept(grid, degree, i, j); ++i) {
            const std::size_t name = key(i, j);
            if (index_of[name] >= 0) continue;
            index_of[name] = 0;
            const Wavevector q = wavevector(grid, i, j);
            // In a square by k^2, not by one of its modes: the same number on every grid of the same cell.
            entries.push_back(
                {.q = square ? 2.0 * std::numbers::pi / grid.lx * std::sqrt(static_cast<double>(square_of(i, j)))
                             : std::hypot(q.x, q.y),
                 .key = name});
        }
    std::ranges::sort(entries, [](const Entry& a, const Entry& b) { return a.q < b.q; });
    DistinctWavenumbers result;
    for (const Entry& entry : entries) {
        const bool is_repeated = !result.q.empty() && result.q.back() == entry.q;
        if (!is_repeated) {
            result.q.push_back(entry.q);
            result.inverse.push_back(entry.q == 0.0 ? 0.0 : 1.0 / entry.q);
        }
        index_of[entry.key] = static_cast<std::int32_t>(result.q.size()) - 1;
    }
    result.of_mode.assign(modes(grid), -1);
    for (std::size_t j = 0; j < rows; ++j)
        for (std::size_t i = 0; i < width && is_kept(grid, degree, i, j); ++i)
            result.of_mode[j * width + i] = index_of[key(i, j)];
    return result;
}

}  // namespace drover::numerics
