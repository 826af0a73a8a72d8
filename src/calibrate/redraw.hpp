// calibrate/redraw.hpp: tables whose numbers are drawn anew within their errors.
#pragma once
#include <string>
#include <vector>

#include "calibrate/table.hpp"

namespace drover::calibrate {

/// Of errors of numbers at one point: half widths are then known to a few per cent also where they are skewed.
inline constexpr int point_draws = 400;

/// Tables with normal errors added to the entries of these rows, as far as the table has them.  Errors are independent
/// but for that of c, which is always drawn anew: it is derived from the redrawn rows and gets its own error.  A table
/// with more alignment by the flow has less by contacts, since their sum was measured.  An entry has the same draws
/// whatever the other rows are.
std::vector<Table> redrawn_tables(const Table& table, const std::vector<std::string>& rows, int count);

}  // namespace drover::calibrate
