// calibrate/redraw.hpp: tables whose numbers are drawn anew within their errors.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "calibrate/table.hpp"

namespace drover::calibrate {

/// Of errors of numbers: half widths are then known to a few per cent also where they are skewed.
inline constexpr int error_draws = 400;

/// Whether others follow from this row, so that what it shares with those of the same trials matters.
bool is_input(const std::string& row);

/// Deviations of an entry in all draws: normal ones, in the order of the resamples of its trials, so that entries of
/// one assay at one point vary together.  Without those, in an order that depends on the row and the entry alone, but
/// for the slopes of lines whose covariance with their constant the table has.
std::vector<double> deviations(const Table& table, const TableRow& row, std::size_t entry, std::size_t count);

/// These rows of the table, as far as it has them, with what values and draws need alone.
Table slim(Table table, const std::vector<std::string>& rows);

/// Tables with these rows, as far as the table has them, drawn anew within their errors; the drawn numbers have none.
/// c follows from the redrawn rows of its assays, which are drawn with it, and varies in addition by what its
/// measurements disagree: a table with more alignment by the flow has less by contacts, since their sum was measured.
/// A response time stays positive: its logarithm is drawn.  An entry has the same draws whatever the other rows are.
void for_redrawn_tables(const Table& table, std::vector<std::string> rows, int count,
                        const std::function<void(Table&)>& visit);
/// The same, all at once.
std::vector<Table> redrawn_tables(const Table& table, std::vector<std::string> rows, int count);

}  // namespace drover::calibrate
