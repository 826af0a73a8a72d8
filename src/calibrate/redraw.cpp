// calibrate/redraw.cpp: tables whose numbers are drawn anew within their errors.
#include "calibrate/redraw.hpp"

#include <algorithm>

#include "base/draws.hpp"
#include "calibrate/closures.hpp"

namespace drover::calibrate {

namespace {
/// Draws of one entry for all tables.
std::vector<double> draws_of(const std::string& row, std::size_t entry, std::size_t count) {
    std::uint64_t named = 14695981039346656037u;  // FNV-1a
    for (const char letter : row) named = (named ^ static_cast<unsigned char>(letter)) * 1099511628211u;
    return normal_draws(named, entry, count);
}
}  // namespace

std::vector<Table> redrawn_tables(const Table& table, const std::vector<std::string>& rows, int count) {
    const auto is_wanted = [&](const std::string& name) {
        return std::find(rows.begin(), rows.end(), name) != rows.end();
    };
    Table few = table;
    std::erase_if(few.rows, [&](const TableRow& row) {
        return !is_wanted(row.name) && !row.name.starts_with("alignment_") && !row.name.starts_with("contact_") &&
               row.name != straight_drag;
    });
    for (TableRow& row : few.rows)
        for (TableEntry& entry : row.entries)
            if (entry.origin != Origin::missing) entry.remark.clear();
    const auto draws = static_cast<std::size_t>(count);
    std::vector<Table> tables(draws, few);
    for (std::size_t r = 0; r < few.rows.size(); ++r) {
        const TableRow& row = few.rows[r];
        for (std::size_t i = 0; i < row.entries.size(); ++i) {
            const double error = row.entries[i].error;
            if (row.name == row_name(contact) || !is_wanted(row.name) || !(error > 0.0)) continue;
            const std::vector<double> normal = draws_of(row.name, i, draws);
            for (std::size_t k = 0; k < draws; ++k) tables[k].rows[r].entries[i].value += normal[k] * error;
        }
    }
    if (find_row(few, row_name(contact)) == nullptr) return tables;
    const std::vector<Uncertain> alone = contact_alone(table);
    std::vector<std::vector<double>> normal;
    for (std::size_t i = 0; i < alone.size(); ++i) normal.push_back(draws_of(row_name(contact), i, draws));
    for (std::size_t k = 0; k < draws; ++k) {
        const std::vector<Uncertain> derived = contact_alone(tables[k]);
        for (TableRow& row : tables[k].rows)
            for (std::size_t i = 0; row.name == row_name(contact) && i < derived.size(); ++i)
                row.entries[i].value = derived[i].value + normal[i][k] * alone[i].error;
    }
    return tables;
}

}  // namespace drover::calibrate
