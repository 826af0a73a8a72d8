// numerics/fields/shells.cpp: the distinct |q| of a grid; averages over shells and sectors of q, and box windows.
#include "numerics/fields/shells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>

#include "base/constants.hpp"
#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
/// Radius, in units of 2 pi / longest side, within which every mode is kept: that of the first mode not kept.
double radius_kept(const Grid& grid, int degree, double ratio_x, double ratio_y) {
    std::size_t column = 0, row = 0;
    while (column < columns(grid) && is_kept(grid, degree, column, 0)) ++column;
    while (row <= static_cast<std::size_t>(grid.ny / 2) && is_kept(grid, degree, 0, row)) ++row;
    if (grid.ny == 1) return ratio_x * static_cast<double>(column);
    return std::min(ratio_x * static_cast<double>(column), ratio_y * static_cast<double>(row));
}

/// [dx sin(q b/2)/sin(q dx/2)]^2 of mode numbers 0 .. n - 1, b = cells dx.
std::vector<double> window_squares(int n, int cells, double dx) {
    std::vector<double> window(static_cast<std::size_t>(n));
    window[0] = std::pow(dx * cells, 2);
    for (int i = 1; i < n; ++i) {
        const auto reduced =
            static_cast<double>(std::int64_t{i} * cells % n);  // sin^2 has period n: avoids large angles
        const double sine = std::sin(std::numbers::pi * reduced / n) / std::sin(std::numbers::pi * i / n);
        window[static_cast<std::size_t>(i)] = std::pow(dx * sine, 2);
    }
    return window;
}
}  // namespace

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

Shells shells(const Grid& grid, int degree) {
    const double longest = grid.ny == 1 ? grid.lx : std::max(grid.lx, grid.ly);  // a line has waves along x alone
    const double ratio_x = longest / grid.lx, ratio_y = longest / grid.ly;
    const double radius = radius_kept(grid, degree, ratio_x, ratio_y);
    const auto count = static_cast<std::size_t>(std::max(0.0, std::floor(radius - 0.5)));

    Shells result{.q = std::vector<double>(count),
                  .weight = std::vector<double>(count),
                  .of_mode = std::vector<int>(modes(grid), -1)};
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i, ++mode) {
            // In these units, not in 1/mm, so that no shell of a square grid depends on rounding.
            const double x = ratio_x * static_cast<double>(i), y = ratio_y * mode_number_y(grid, j);
            const double shell = std::floor(std::sqrt(x * x + y * y) - 0.5);
            if (shell < 0.0 || shell >= static_cast<double>(count)) continue;
            const auto n = static_cast<std::size_t>(shell);
            const Wavevector q = wavevector(grid, i, j);
            result.of_mode[mode] = static_cast<int>(n);
            result.weight[n] += mode_weight(grid, i);
            result.q[n] += mode_weight(grid, i) * std::hypot(q.x, q.y);
        }
    for (std::size_t n = 0; n < count; ++n) result.q[n] /= result.weight[n];
    return result;
}

Sectors sectors(const Grid& grid, int count) {
    require(count >= 1, {}, "{} sectors of direction; expected at least 1", count);
    Sectors result{.count = count, .of_mode = std::vector<int>(modes(grid), -1)};
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i, ++mode) {
            if (i == 0 && j == 0) continue;
            const Wavevector q = wavevector(grid, i, j);
            const double angle =
                q.y < 0.0 ? std::atan2(-q.y, -q.x) : std::atan2(q.y, q.x);  // stored modes have q.x >= 0
            result.of_mode[mode] = static_cast<int>(angle / std::numbers::pi * count + 0.5) % count;
        }
    return result;
}

std::vector<double> shell_means(const Grid& grid, const Shells& shells, std::span<const double> per_mode) {
    std::vector<double> means(shells.q.size());
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i, ++mode)
            if (shells.of_mode[mode] >= 0)
                means[static_cast<std::size_t>(shells.of_mode[mode])] += mode_weight(grid, i) * per_mode[mode];
    for (std::size_t n = 0; n < means.size(); ++n) means[n] /= shells.weight[n];
    return means;
}

std::vector<double> sector_means(const Grid& grid, const Shells& shells, const Sectors& sectors,
                                 std::span<const double> per_mode) {
    const std::size_t size = static_cast<std::size_t>(sectors.count) * shells.q.size();
    std::vector<double> means(size), weights(size);
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i, ++mode) {
            if (shells.of_mode[mode] < 0) continue;
            const std::size_t cell = static_cast<std::size_t>(sectors.of_mode[mode]) * shells.q.size() +
                                     static_cast<std::size_t>(shells.of_mode[mode]);
            means[cell] += mode_weight(grid, i) * per_mode[mode];
            weights[cell] += mode_weight(grid, i);
        }
    for (std::size_t n = 0; n < size; ++n) means[n] = weights[n] > 0.0 ? means[n] / weights[n] : nan;
    return means;
}

double box_variance(const Grid& grid, std::span<const double> power, int cells_x, int cells_y) {
    require(cells_x >= 1 && cells_x <= grid.nx && cells_y >= 1 && cells_y <= grid.ny, {},
            "a box of {} by {} cells; expected 1 to {} by 1 to {}", cells_x, cells_y, grid.nx, grid.ny);
    const std::vector<double> window_x = window_squares(grid.nx, cells_x, grid.lx / grid.nx);
    const std::vector<double> window_y = window_squares(grid.ny, cells_y, grid.ly / grid.ny);
    std::vector<double> by_column(columns(grid));  // sums over y first: the loops over a row vectorise
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j) {
        const double* row = power.data() + j * columns(grid);
        for (std::size_t i = j == 0 ? 1 : 0; i < by_column.size(); ++i) by_column[i] += window_y[j] * row[i];
    }
    double variance = 0.0;
    for (std::size_t i = 0; i < by_column.size(); ++i) variance += mode_weight(grid, i) * window_x[i] * by_column[i];
    return variance;
}

std::vector<int> box_ladder(int n) {
    std::vector<int> sides;
    for (int side = 1; side <= n / 2; side *= 2) {
        sides.push_back(side);
        if (side > 1 && 3 * side / 2 <= n / 2) sides.push_back(3 * side / 2);
    }
    return sides;
}

}  // namespace drover::numerics
