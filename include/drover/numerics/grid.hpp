// numerics/grid.hpp: the periodic grid, its wavevectors, and which of them are kept.
#pragma once
#include <cstddef>
#include <numbers>

#include "drover/base/schema.hpp"

namespace drover::numerics {

/// A periodic rectangle.  Real arrays are [y][x], x fastest.  Spectral arrays have the layout of the real-to-complex
/// transform: [ny][nx/2 + 1], column i the mode number i along x, row j the mode number j or j - ny along y.
struct Grid {
    int nx = 256;      ///< points along x, even, 4 to max_points_along
    int ny = 256;      ///< points along y, as nx; or 1: fields that do not depend on y
    double lx = 64.0;  ///< side along x [length]: that of the model, mm in scenes
    double ly = 64.0;  ///< side along y

    static Rows<Grid> rows();
};

struct Wavevector {
    double x = 0.0, y = 0.0;  ///< [1/length]
};

inline std::size_t points(const Grid& grid) {
    return static_cast<std::size_t>(grid.nx) * static_cast<std::size_t>(grid.ny);
}
inline std::size_t columns(const Grid& grid) { return static_cast<std::size_t>(grid.nx / 2 + 1); }
inline std::size_t modes(const Grid& grid) { return columns(grid) * static_cast<std::size_t>(grid.ny); }
inline double area(const Grid& grid) { return grid.lx * grid.ly; }

/// Signed mode number of row j: 0, 1, ..., ny/2 - 1, -ny/2, ..., -1; 0 on one row.
inline int mode_number_y(const Grid& grid, std::size_t j) {
    const int row = static_cast<int>(j);
    return row < (grid.ny + 1) / 2 ? row : row - grid.ny;
}

inline Wavevector wavevector(const Grid& grid, std::size_t column, std::size_t row) {
    constexpr double turn = 2.0 * std::numbers::pi;
    return {.x = turn / grid.lx * static_cast<double>(column), .y = turn / grid.ly * mode_number_y(grid, row)};
}

/// Whether a mode of a product of `degree` factors is free of aliases: |k| < N/(degree + 1) on each axis.  Degree 1
/// excludes only the Nyquist modes, whose odd derivatives are not real fields.
bool is_kept(const Grid& grid, int degree, std::size_t column, std::size_t row);

/// Twice that of scenes, whose formulas are compared with those on a finer grid.
inline constexpr int max_points_along = 131072;

/// Throws an input Error unless sizes are even, >= 4 and at most max_points_along, or ny is 1, and sides positive and
/// finite.
void check(const Grid& grid, const Locate& locate = no_location);

}  // namespace drover::numerics
