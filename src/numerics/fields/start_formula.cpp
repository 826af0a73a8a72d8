// numerics/fields/start_formula.cpp: what a grid makes of the formulas of a start, in words.
#include "numerics/fields/start_formula.hpp"

#include <cmath>
#include <map>
#include <mutex>
#include <tuple>

#include "numerics/fields/formula_on_grid.hpp"

namespace drover::numerics {

namespace {
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
    const Grid finer = grid_that_resolves(formula.value, grid, degree, max_variance_cut);
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
    const std::size_t cell = fill_cells(formula.value, grid, threads, values);
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
        fail_input(formula.where, "{} = \"{}\": the grid cuts {:.3g} of its variance; expected less than half: {}",
                   formula.key, formula.written, cut, remedy(formula, grid, degree));
}

std::string warning_of(const StartFormula& formula, const std::string& unit, const Grid& grid, int degree) {
    if (const EdgeJump jump = edge_jump(formula.value, grid);
        jump.size > max_edge_jump * jump.range && jump.range > 0.0)
        return text(
            "{} = \"{}\" jumps by {:.3g} {} at the periodic edge {} = 0, at {} = {:.4g} mm: the waves of the grid "
            "overshoot there; write a formula with the periods of the cell, {} = {} and {} = {} mm",
            formula.key, formula.written, jump.size, unit, jump.axis, jump.axis == 'x' ? 'y' : 'x', jump.at, "grid.lx",
            grid.lx, "grid.ly", grid.ly);
    if (const double cut = remembered_cut(formula, grid, degree); cut > max_variance_cut)
        return text("{} = \"{}\": the grid cuts {:.2g} of its variance; expected less than {}: {}", formula.key,
                    formula.written, cut, max_variance_cut, remedy(formula, grid, degree));
    return "";
}

}  // namespace drover::numerics
