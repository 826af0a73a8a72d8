// numerics/fields/formula_on_grid.cpp: what a grid does to a formula in x, y, lx and ly.
#include "numerics/fields/formula_on_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "base/constants.hpp"
#include "drover/numerics/transform.hpp"

namespace drover::numerics {

namespace {

double value_at(const Expression& formula, const Grid& grid, double x, double y) {
    return evaluate(formula, std::array{x, y, grid.lx, grid.ly});
}
}  // namespace

Fields values_on(const Expression& formula, const Grid& grid, double shift_x, double shift_y) {
    Fields cells(grid, 1);
    const StripProgram program(std::span(&formula, 1));
    const auto nx = static_cast<std::size_t>(grid.nx);
    std::vector<double> x(nx);
    const bool has_y = slots_of(formula).contains(1);
    for (std::size_t i = 0; i < nx; ++i) x[i] = grid.lx / grid.nx * static_cast<double>(i) + shift_x;
    for (int j = 0; j < grid.ny; ++j) {
        const std::array uniform{0.0, grid.ly / grid.ny * j + shift_y, grid.lx, grid.ly};  // the same along a row
        double* row = cells[0].data() + static_cast<std::size_t>(j) * nx;
        if (j > 0 && !has_y) std::copy_n(cells[0].data(), nx, row);
        else program.write(nx, std::array<const double*, 4>{x.data()}, uniform, std::array{row});
    }
    return cells;
}

double fraction_cut(const Expression& formula, const Grid& grid, int degree) {
    if (slots_of(formula).empty()) return std::isfinite(evaluate(formula, {})) ? 0.0 : nan;
    Threads one(1);
    const Transform transform(grid, degree, one);
    Spectra modes(grid, 1);
    transform.forward(values_on(formula, grid), modes);
    const std::size_t width = columns(grid);
    // Irrational fractions of a cell: a wave that the points alias to a longer one disagrees with it there.
    double error = 0.0, square = 0.0, sum = 0.0, largest = 0.0, count = 0.0;
    for (const auto& [part_x, part_y] :
         {std::pair{0.6180339887, 0.4142135624}, std::pair{0.2360679775, 0.7320508076}}) {
        const double shift_x = part_x * grid.lx / grid.nx, shift_y = part_y * grid.ly / grid.ny;
        Spectra shifted = modes;
        std::vector<Complex> turn_x;
        for (std::size_t i = 0; i < width; ++i) turn_x.push_back(std::polar(1.0, wavevector(grid, i, 0).x * shift_x));
        for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j) {
            const Complex turn_y = std::polar(1.0, wavevector(grid, 0, j).y * shift_y);
            for (std::size_t i = 0; i < width; ++i) shifted[0][j * width + i] *= turn_x[i] * turn_y;
        }
        Fields kept(grid, 1);
        transform.backward(shifted, kept);
        const Fields exact = values_on(formula, grid, shift_x, shift_y);
        for (std::size_t i = 0; i < exact.size; ++i) {
            const double value = exact[0][i];
            error += (value - kept[0][i]) * (value - kept[0][i]);
            square += value * value;
            sum += value;
            largest = std::max(largest, std::abs(value));
            count += 1.0;
        }
    }
    if (!std::isfinite(error)) return nan;
    const double rounding = 1e-12 * largest, variance = square / count - (sum / count) * (sum / count);
    if (error <= rounding * rounding * count) return 0.0;
    return error / count / std::max(variance, error / count);
}

Grid grid_that_resolves(const Expression& formula, const Grid& grid, int degree, double max_cut) {
    constexpr double few = 1024.0 * 1024.0, many = 2048.0 * 2048.0;  // bounds the time of the search
    const double max_points = std::clamp(4.0 * grid.nx * grid.ny, few, many);
    for (int factor = 2; factor <= 64; factor *= 2)
        for (const auto& [x, y] : {std::pair{factor, 1}, std::pair{1, factor}, std::pair{factor, factor}}) {
            const int rows = grid.ny == 1 && y > 1 ? 2 * y : grid.ny * y;
            const Grid finer{.nx = grid.nx * x, .ny = rows, .lx = grid.lx, .ly = grid.ly};
            if (1.0 * finer.nx * finer.ny <= max_points && fraction_cut(formula, finer, degree) < max_cut) return finer;
        }
    return grid;
}

std::size_t fill_cells(const Expression& formula, const Grid& grid, Threads& threads, std::span<double> values) {
    const auto nx = static_cast<std::size_t>(grid.nx);
    constexpr std::size_t cells_per_chunk = 4096;
    // Operation by operation: strips would fold 0 times infinity to 0.
    threads.for_chunks(values.size(), cells_per_chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t m = begin; m < end; ++m)
            values[m] = value_at(formula, grid, grid.lx / grid.nx * static_cast<double>(m % nx),
                                 grid.ly / grid.ny * static_cast<double>(m / nx));
    });
    const auto found = std::find_if(values.begin(), values.end(), [](double value) { return !std::isfinite(value); });
    return static_cast<std::size_t>(found - values.begin());
}

EdgeJump edge_jump(const Expression& formula, const Grid& grid) {
    EdgeJump jump;
    const Fields cells = values_on(formula, grid);
    const auto [min, max] = std::minmax_element(cells.values.begin(), cells.values.end());
    jump.range = *max - *min;
    constexpr double inside = 1e-9;  // of the side: a formula may have another value on the edge itself
    const auto take = [&](char axis, double size, double at) {
        if (std::abs(size) > jump.size) jump = {.size = std::abs(size), .range = jump.range, .axis = axis, .at = at};
    };
    for (int j = 0; j < grid.ny; ++j) {
        const double y = grid.ly / grid.ny * j;
        take('x', value_at(formula, grid, grid.lx * (1.0 - inside), y) - value_at(formula, grid, grid.lx * inside, y),
             y);
    }
    for (int i = 0; i < grid.nx; ++i) {
        const double x = grid.lx / grid.nx * i;
        take('y', value_at(formula, grid, x, grid.ly * (1.0 - inside)) - value_at(formula, grid, x, grid.ly * inside),
             x);
    }
    return jump;
}

}  // namespace drover::numerics
