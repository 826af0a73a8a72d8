// calibrate/redraw.cpp: tables whose numbers are drawn anew within their errors.
#include "calibrate/redraw.hpp"

#include <algorithm>
#include <cmath>

#include "base/draws.hpp"
#include "calibrate/alignment.hpp"
#include "calibrate/closures.hpp"

namespace drover::calibrate {

namespace {
/// Constant and slope of a straight line, which one assay measures, and the row that has their covariance.
struct Line {
    const char *constant, *slope, *referred;
    double reference;
};
constexpr Line lines[]{{"alignment_steady", "alignment_drift", "alignment_reference", reference_time},
                       {"contact_steady", "contact_slope", "contact_reference", reference_rate}};

/// One standard normal number for each draw.
std::vector<double> scores(const TableRow& row, std::size_t entry, std::size_t count) {
    const std::vector<double>& ranks = row.entries[entry].ranks;
    if (ranks.empty()) return normal_draws(random_ranks(number_of_name(row.name), entry, count));
    std::vector<double> order;
    for (std::size_t k = 0; k < count; ++k) order.push_back(ranks[k % ranks.size()]);
    return normal_draws(order);
}

/// Turns those of the slope of a line so that they vary with those of its constant as they should.
void correlate(const Line& line, const Table& table, std::size_t entry, std::vector<double>& of_slope) {
    const TableRow *constants = find_row(table, line.constant), *referred = find_row(table, line.referred);
    if (constants == nullptr || referred == nullptr) return;
    const TableEntry &constant = constants->entries[entry], &slope = find_row(table, line.slope)->entries[entry];
    const double twice = twice_covariance(constant, slope, referred->entries[entry], line.reference),
                 correlation = std::clamp(0.5 * twice / (constant.error * slope.error), -1.0, 1.0);
    if (!std::isfinite(correlation)) return;  // one of them has no error
    const std::vector<double> shared = scores(*constants, entry, of_slope.size());
    for (std::size_t k = 0; k < shared.size(); ++k)
        of_slope[k] = correlation * shared[k] + std::sqrt(1.0 - correlation * correlation) * of_slope[k];
}

/// A drawn number has no error; but between response times the interpolation may fall below zero.
void clear_errors(Table& table) {
    constexpr double least = 0.05;  // of the error, the smallest that is drawn
    for (TableRow& row : table.rows)
        for (TableEntry& entry : row.entries) entry.error *= row.name == name_of(response) ? least : 0.0;
}

/// An entry that is drawn anew, and its deviations().
struct DrawnEntry {
    std::size_t row, entry;
    std::vector<double> apart;
};

std::vector<DrawnEntry> drawn_entries(const Table& few, const Table& whole, std::size_t draws) {
    std::vector<DrawnEntry> drawn;
    for (std::size_t r = 0; r < few.rows.size(); ++r)
        for (std::size_t i = 0; i < few.rows[r].entries.size(); ++i)
            if (const TableRow& row = *find_row(whole, few.rows[r].name); few.rows[r].entries[i].error > 0.0)
                drawn.push_back({r, i, deviations(whole, row, i, draws)});
    return drawn;
}

void move(TableRow& row, std::size_t i, double by) {
    TableEntry& entry = row.entries[i];
    const double time = std::max(entry.value, entry.error);  // as put() replaces it
    entry.value = row.name == name_of(response) ? time * std::exp(by / time) : entry.value + by;
}
}  // namespace

bool is_input(const std::string& row) { return value_named<Input>(row) || std::ranges::count(contact_rows(), row) > 0; }

Table slim(Table table, const std::vector<std::string>& rows) {
    std::erase_if(table.rows, [&](const TableRow& row) { return std::ranges::count(rows, row.name) == 0; });
    for (TableRow& row : table.rows)
        for (TableEntry& entry : row.entries) {
            if (entry.origin != Origin::missing) entry.remark.clear();
            if (entry.origin == Origin::measured_short) entry.origin = Origin::measured;
            entry.ranks.clear();
        }
    return table;
}

std::vector<double> deviations(const Table& table, const TableRow& row, std::size_t entry, std::size_t count) {
    std::vector<double> found = scores(row, entry, count);
    if (row.entries[entry].ranks.empty())
        for (const Line& line : lines)
            if (row.name == line.slope) correlate(line, table, entry, found);
    for (double& one : found) one *= row.entries[entry].error;
    return found;
}

void for_redrawn_tables(const Table& table, std::vector<std::string> rows, int count,
                        const std::function<void(Table&)>& visit) {
    const auto draws = static_cast<std::size_t>(count);
    const std::string contacts = name_of(contact);
    const TableRow* measured = find_row(table, contacts);
    const bool derives_contacts =
        measured && std::ranges::find(rows, contacts) != rows.end() && has_contact_rows(table) &&
        std::ranges::any_of(measured->entries, [](const TableEntry& one) { return one.origin == Origin::measured; });
    if (derives_contacts) {
        std::erase(rows, contacts);
        rows.insert(rows.end(), contact_rows().begin(), contact_rows().end());
        rows.emplace_back(name_of(rod_area));
    }
    const Table few = slim(table, rows);
    const std::vector<DrawnEntry> drawn = drawn_entries(few, table, draws);
    std::vector<DrawnEntry> alone;  // of c, by what its measurements disagree
    if (derives_contacts) {
        Table with_contacts = few;
        add_contact_alignment(with_contacts);
        alone = drawn_entries(slim(with_contacts, {contacts}), with_contacts, draws);
    }
    for (std::size_t k = 0; k < draws; ++k) {
        Table one = few;
        for (const DrawnEntry& entry : drawn) move(one.rows[entry.row], entry.entry, entry.apart[k]);
        if (derives_contacts) add_contact_alignment(one);
        for (const DrawnEntry& entry : alone)
            std::ranges::find(one.rows, contacts, &TableRow::name)->entries[entry.entry].value += entry.apart[k];
        clear_errors(one);
        visit(one);
    }
}

std::vector<Table> redrawn_tables(const Table& table, std::vector<std::string> rows, int count) {
    std::vector<Table> tables;
    for_redrawn_tables(table, std::move(rows), count, [&](Table& one) { tables.push_back(std::move(one)); });
    return tables;
}

}  // namespace drover::calibrate
