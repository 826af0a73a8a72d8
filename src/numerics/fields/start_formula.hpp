// numerics/fields/start_formula.hpp: formulas in x, y, lx and ly for the fields at the start of a run, checked on their
// grid.
#pragma once
#include <string>

#include "drover/base/error.hpp"
#include "drover/base/expression.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// A formula is resolved if the grid cuts less than this fraction of its variance: 3 % of its root mean square.
inline constexpr double max_variance_cut = 1e-3;
/// Largest jump at a periodic edge, as a fraction of the range of the formula in the cell.
inline constexpr double max_edge_jump = 0.01;

struct StartFormula {
    std::string key;      ///< of the scene: "initial.rod_density"
    std::string written;  ///< its text
    SourceLocation where;
    Expression value;  ///< of x, y and the sides of the cell, lx and ly (slots 0 to 3)
};
/// Parses a formula.  Throws an input Error at `where` as parse_expression().
StartFormula read_start_formula(std::string key, std::string written, const SourceLocation& where);

/// Throws an input Error for a formula that is not finite in every cell, and for one of whose variance the grid cuts
/// more than half.
void check(const StartFormula& formula, const Grid& grid, int degree);

/// That the grid cuts the formula, or that it jumps at a periodic edge, with the remedy; "" for neither.
/// unit: of the field.
std::string warning_of(const StartFormula& formula, const std::string& unit, const Grid& grid, int degree);

/// The values in the cells.  Throws an input Error where one is not finite.
void fill(const StartFormula& formula, const Grid& grid, Threads& threads, std::span<double> values);

}  // namespace drover::numerics
