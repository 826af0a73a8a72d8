// calibrate/redraw.hpp: tables whose numbers are drawn anew within their errors.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"

namespace drover::calibrate {

/// Tables with normal errors added to the entries of these rows, as far as the table has them.  Errors are independent
/// but for that of c, which is always drawn anew: it is derived from the redrawn rows and gets its own error.  A table
/// with more alignment by the flow has less by contacts, since their sum was measured.
std::vector<Table> redrawn_tables(const Table& table, const std::vector<std::string>& rows, int count);

/// 16, 50 and 84 % of values; NaN for none.
std::array<double, 3> quantiles_of(std::vector<double> values);

}  // namespace drover::calibrate
