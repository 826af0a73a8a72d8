// numerics/fields/start_formula.cpp: what a grid makes of the formulas of a start.
#include "numerics/fields/start_formula.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>
#include <vector>

#include "base/constants.hpp"
#include "drover/numerics/transform.hpp"

namespace drover::numerics {

namespace {
double value_at(const Expression& formula, const Grid& grid, double x, double y) {
    return evaluate(formula, std::array{x, y, grid.lx, grid.ly});
}

/// The formula at the points of a grid, shifted by a displacement [mm]; one field.
Fields values_on(const Expression& formula, const Grid& grid, double shift_x = 0.0, double shift_y = 0.0) {
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

/// The fraction of the variance of a formula that a grid cuts or aliases: the mean square difference from its kept
/// modes, between the points.  0 for a constant.  NaN if the formula is not finite everywhere.
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

/// The smallest of up to 64 times as many points on one axis or both that the formula needs; the grid itself if none
/// do.
Grid grid_that_resolves(const Expression& formula, const Grid& grid, int degree) {
    constexpr double few = 1024.0 * 1024.0, many = 2048.0 * 2048.0;  // bounds the time of the search
    const double max_points = std::clamp(4.0 * grid.nx * grid.ny, few, many);
    for (int factor = 2; factor <= 64; factor *= 2)
        for (const auto& [x, y] : {std::pair{factor, 1}, std::pair{1, factor}, std::pair{factor, factor}}) {
            const int rows = grid.ny == 1 && y > 1 ? 2 * y : grid.ny * y;
            const Grid finer{.nx = grid.nx * x, .ny = rows, .lx = grid.lx, .ly = grid.ly};
            if (1.0 * finer.nx * finer.ny <= max_points && fraction_cut(formula, finer, degree) < max_variance_cut)
                return finer;
        }
    return grid;
}

/// The largest jump of a formula across a periodic edge.
struct EdgeJump {
    double size = 0.0;   ///< in the unit of the field
    double range = 0.0;  ///< of the field in the cell
    char axis = 'x';     ///< the axis that crosses the edge
    double at = 0.0;     ///< the other coordinate [mm]
};
EdgeJump edge_jump(const Expression& formula, const Grid& grid) {
    EdgeJump jump;
    const Fields cells = values_on(formula, grid);
    const auto [min, max] = std::ranges::minmax_element(cells.values);
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

/// fraction_cut, kept for the formulas of one scene: a run asks for it in its checks and again in its warnings.
double remembered_cut(const StartFormula& formula, const Grid& grid, int degree) {
    constexpr std::size_t max_kept = 8;
    static std::mutex& mutex = new_mutex_over_forks();
    static std::map<std::tuple<std::string, int, int, double, double, int>, double> kept;
    const std::tuple key{formula.written, grid.nx, grid.ny, grid.lx, grid.ly, degree};
    {
        const std::lock_guard lock(mutex);
        if (const auto found = kept.find(key); found != kept.end()) return found->second;
    }
    const double cut = fraction_cut(formula.value, grid, degree);
    const std::lock_guard lock(mutex);
    if (kept.size() >= max_kept) kept.clear();
    return kept[key] = cut;
}

std::string remedy(const StartFormula& formula, const Grid& grid, int degree) {
    const Grid finer = grid_that_resolves(formula.value, grid, degree);
    std::string words;
    if (finer.nx != grid.nx) words = text("grid.nx = {}", finer.nx);
    if (finer.ny != grid.ny) words += text("{}grid.ny = {}", words.empty() ? "" : " and ", finer.ny);
    return words.empty() ? "make it smoother" : "choose " + words + " or make it smoother";
}
}  // namespace

StartFormula read_start_formula(std::string key, std::string written, const SourceLocation& where) {
    Expression value = parse_expression(written, {.variables = {{"x", 0}, {"y", 1}, {"lx", 2}, {"ly", 3}}}, where);
    return {std::move(key), std::move(written), where, std::move(value)};
}

void fill(const StartFormula& formula, const Grid& grid, Threads& threads, std::span<double> values) {
    const auto nx = static_cast<std::size_t>(grid.nx);
    constexpr std::size_t cells_per_chunk = 4096;
    // Operation by operation: strips would fold 0 times infinity to 0.
    threads.for_chunks(values.size(), cells_per_chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t m = begin; m < end; ++m)
            values[m] = value_at(formula.value, grid, grid.lx / grid.nx * static_cast<double>(m % nx),
                                 grid.ly / grid.ny * static_cast<double>(m / nx));
    });
    const auto found = std::ranges::find_if(values, [](double value) { return !std::isfinite(value); });
    const auto cell = static_cast<std::size_t>(found - values.begin());
    if (cell < values.size())
        fail_input(formula.where, "{} = \"{}\" is {} in cell ({}, {}); expected a finite number in every cell",
                   formula.key, formula.written, values[cell], cell % nx, cell / nx);
}

void check(const StartFormula& formula, const Grid& grid, int degree) {
    const double cut = remembered_cut(formula, grid, degree);
    if (!std::isfinite(cut)) {
        Threads one(1);
        Fields cells(grid, 1);
        fill(formula, grid, one, cells[0]);
    }
    if (cut > 0.5)
        fail_input(formula.where, "{} = \"{}\": the grid cuts off {:.3g} of its variance; expected less than half: {}",
                   formula.key, formula.written, cut, remedy(formula, grid, degree));
}

std::string warning_of(const StartFormula& formula, const std::string& unit, const Grid& grid, int degree) {
    if (const EdgeJump jump = edge_jump(formula.value, grid);
        jump.size > max_edge_jump * jump.range && jump.range > 0.0)
        return text(
            "{} = \"{}\" jumps by {:.3g} {} at the periodic edge {} = 0, at {} = {:.4g} mm: its truncated Fourier "
            "series overshoots there; write a formula that is periodic in the cell, {} = {} and {} = {} mm",
            formula.key, formula.written, jump.size, unit, jump.axis, jump.axis == 'x' ? 'y' : 'x', jump.at, "grid.lx",
            grid.lx, "grid.ly", grid.ly);
    if (const double cut = remembered_cut(formula, grid, degree); cut > max_variance_cut)
        return text("{} = \"{}\": the grid cuts off {:.2g} of its variance; expected less than {}: {}", formula.key,
                    formula.written, cut, max_variance_cut, remedy(formula, grid, degree));
    return "";
}

}  // namespace drover::numerics
