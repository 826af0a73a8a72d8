// numerics/fields/grid.cpp: wavevectors of the periodic grid and which modes are kept.
#include "drover/numerics/grid.hpp"

#include <cmath>
#include <cstdlib>

#include "drover/base/error.hpp"

namespace drover::numerics {

bool is_kept(const Grid& grid, int degree, std::size_t column, std::size_t row) {
    return static_cast<int>(column) * (degree + 1) < grid.nx &&
           std::abs(mode_number_y(grid, row)) * (degree + 1) < grid.ny;
}

void check(const Grid& grid, const Locate& locate) {
    require(grid.nx >= 4 && grid.nx % 2 == 0, locate("grid.nx"), "grid.nx = {}; expected an even number >= 4", grid.nx);
    require(grid.ny == 1 || (grid.ny >= 4 && grid.ny % 2 == 0), locate("grid.ny"),
            "grid.ny = {}; expected an even number >= 4, or 1 for fields that do not depend on y", grid.ny);
    for (const auto& [name, count] : {std::pair{"nx", grid.nx}, std::pair{"ny", grid.ny}})
        require(count <= max_points_along, locate(text("grid.{}", name)), "grid.{} = {}; expected at most {}", name,
                count, max_points_along);
    for (const auto& [name, side] : {std::pair{"lx", grid.lx}, std::pair{"ly", grid.ly}})
        require(std::isfinite(side) && side > 0.0, locate(text("grid.{}", name)),
                "grid.{} = {}; expected a positive length", name, side);
}

Rows<Grid> Grid::rows() {
    constexpr Range size{.min = 4, .max = max_points_along / 2}, size_or_one{.min = 1, .max = max_points_along / 2};
    return Rows<Grid>{
        {"nx", &Grid::nx, "points along x, an even number; a one-dimensional grid lies along x, with ny = 1", "", size},
        {"ny", &Grid::ny, "points along y, an even number; 1: one-dimensional, nothing depends on y", "", size_or_one},
        {"lx", &Grid::lx, "side of the periodic cell along x", "mm", positive},
        {"ly", &Grid::ly,
         "side of the periodic cell along y; with ny = 1 the width over which densities and shot noise are "
         "averaged",
         "mm", positive},
    };
}

}  // namespace drover::numerics
