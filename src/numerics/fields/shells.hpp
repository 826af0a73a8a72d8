// numerics/fields/shells.hpp: the distinct |q| of a grid, for quantities that depend only on |q|; shells of |q|,
// sectors of its direction, and box windows; shared by measurement and theory.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "drover/numerics/field.hpp"
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

/// The modes of a grid sorted into shells of width dq = 2 pi / max(lx, ly), shell n holding |q|/dq in [n + 1/2, n +
/// 3/2), out to the largest circle inside the kept modes: complete, non-empty shells only.  q = 0 is in none.
struct Shells {
    std::vector<double> q;       ///< mean |q| over each shell's modes [1/mm]
    std::vector<double> weight;  ///< number of modes in each shell, both of every pair q, -q
    std::vector<int> of_mode;    ///< shell of each stored mode, -1 for none
};
Shells shells(const Grid& grid, int degree);

/// The same by direction: sector s of `count` holds the angles of q (in [0, pi); q and -q are equivalent) in
/// [(s - 1/2), (s + 1/2)) pi/count: sector 0 lies along x, sector count/2 along y.
struct Sectors {
    int count = 0;
    std::vector<int> of_mode;  ///< sector of each stored mode (q = 0: -1)
};
Sectors sectors(const Grid& grid, int count);

/// Number of modes of the plane that a stored mode represents: 1 in columns 0 and nx/2, else 2.
inline double mode_weight(const Grid& grid, std::size_t column) {
    return column == 0 || 2 * column == static_cast<std::size_t>(grid.nx) ? 1.0 : 2.0;
}

/// Sides of a box in cells: `side` times the factors; one cell along y where the grid has no other.
struct BoxCells {
    int x = 1, y = 1;
};
inline BoxCells box_cells(const Grid& grid, int side, int along_x, int along_y) {
    return {.x = along_x * side, .y = grid.ny == 1 ? 1 : along_y * side};
}

/// Mean of a quantity per stored mode over each shell.
std::vector<double> shell_means(const Grid& grid, const Shells& shells, std::span<const double> per_mode);

/// Mean over each sector of each shell, [sector][shell]; NaN where there is no mode.
std::vector<double> sector_means(const Grid& grid, const Shells& shells, const Sectors& sectors,
                                 std::span<const double> per_mode);

/// Variance of the integral of a field over a box of `cells_x` by `cells_y` grid cells, averaged over all its positions
/// on the periodic grid: sum over q != 0 of power_q [dx sin(qx bx/2)/sin(qx dx/2)]^2 [the same for y]^2, with bx =
/// cells_x dx the side of the box and power_q = |a_q|^2 (its mean: S(q)/area).  Exact on the grid (Parseval).  power:
/// of each stored mode; q = 0 is not used.  Throws an input Error unless 1 <= cells <= points on each axis.
double box_variance(const Grid& grid, std::span<const double> power, int cells_x, int cells_y);

/// Box sides to measure, in cells, for a side of n cells: 1, 2, 3, 4, 6, 8, 12, 16, ... up to n/2.
std::vector<int> box_ladder(int n);

}  // namespace drover::numerics
