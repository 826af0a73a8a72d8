// calibrate/table_derived.cpp: rows that follow from measured rows, at each point of a table; tables whose numbers are
// drawn anew within their errors.
#include <algorithm>
#include <cmath>
#include <span>

#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/alignment.hpp"
#include "calibrate/closures.hpp"

namespace drover::calibrate {

namespace {
constexpr const char* no_value = "the closure has no finite value with these numbers";

TableEntry entry_of(const Closure& closure, const std::vector<const TableEntry*>& inputs, ClosureNumbers at) {
    const std::vector<Input>&of = closure.of, &under = closure.under;
    TableEntry result{.origin = closure.origin};
    for (std::size_t i = 0; i < of.size(); ++i) {
        const TableEntry& one = *inputs[i];
        const char* name = name_of(of[i]);
        if (one.origin == Origin::missing) return missing(text("{} is missing", name));
        if (std::ranges::find(under, of[i]) != under.end())
            if (std::string why = divisor_refusal(of[i], one.value, one.error); !why.empty()) return missing(why);
        if (one.origin == Origin::measured_short) {
            if (closure.origin == Origin::measured) result.origin = Origin::measured_short;
            result.remark += text("{}{} has a larger error than requested", result.remark.empty() ? "" : "; ", name);
        }
        if (one.origin != Origin::set)
            result.trials = result.trials == 0 ? one.trials : std::min(result.trials, one.trials);
        if (is_below_error(of[i], one.value, one.error)) {
            result.origin = Origin::closure;
            result.remark += text("{}{} = {:.3g} +- {:.2g}: replaced by its error", result.remark.empty() ? "" : "; ",
                                  name, one.value, one.error);
        }
        put(at, of[i], one.value, one.error);
    }
    result.value = closure.value(at);
    if (!std::isfinite(result.value)) return missing(no_value);
    if (closure.origin == Origin::measured && result.value == 0.0) result.origin = Origin::set;
    return result;
}

/// Fills the row of a closure; false if the table does not have all its inputs.
bool make_row(const Closure& closure, const Table& table, TableRow& row) {
    std::vector<const TableRow*> from;
    for (const Input input : closure.of) {
        from.push_back(find_row(table, name_of(input)));
        if (from.back() == nullptr) return false;
        row.by_rods = row.by_rods || from.back()->by_rods || input == rod_area;
    }
    if (row.by_rods && table.rod_fractions.empty()) return false;
    const std::size_t rods = row.by_rods ? table.rod_fractions.size() : 1;
    for (std::size_t point = 0; point < count_of(table, row.by_rods); ++point) {
        const std::size_t bead = point / rods;
        const auto inputs =
            mapped(from, [&](const TableRow* one) { return &one->entries[one->by_rods ? point : bead]; });
        const std::size_t beads = table.bead_fractions.size();
        const ClosureNumbers at{.bead_fraction = table.bead_fractions[bead % beads],
                                .rod_fraction = row.by_rods ? table.rod_fractions[point % rods] : 0.0};
        row.entries.push_back(entry_of(closure, inputs, at));
    }
    return true;
}
/// Adds a row of zeros unless the table has this row.
void set_to_zero(Table& table, const char* name, const char* unit, const char* formula) {
    if (find_row(table, name) != nullptr) return;
    table.rows.push_back(
        {.name = name,
         .unit = unit,
         .formula = formula,
         .entries = std::vector<TableEntry>(count_of(table, false), TableEntry{.origin = Origin::set})});
}

/// For p = sigma u P, as rows of tables are.
Closure closure_of_row(const Closure& closure) {
    return scaled(closure, {rod_area, speed}, [](const ClosureNumbers& at) { return at.rod_density() * at[speed]; });
}

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

bool lacks_input(const Table& table, const TableRow& row, std::size_t entry) {
    if (row.entries[entry].origin != Origin::missing) return false;
    const std::size_t bead = row.by_rods ? entry / table.rod_fractions.size() : entry;
    for (const Closure& closure : closures()) {
        if (closure.row != row.name) continue;
        for (const Input input : closure_of_row(closure).of)
            if (const TableRow* from = find_row(table, name_of(input));
                from != nullptr && from->entries[from->by_rods ? entry : bead].origin == Origin::missing)
                return true;
    }
    return false;
}

void add_derived_values(Table& table) {
    set_to_zero(table, name_of(stiffness), "mg mm^2/s^2", "E = 0: not measured");
    if (find_row(table, name_of(drag)) != nullptr)
        set_to_zero(table, name_of(cubic), "mm/s", "alpha_3/Gamma = 0: drag is that of a straight line");
    add_contact_alignment(table);
    std::vector<TableRow> rows;
    for (const Closure& closure : closures()) {
        if (closure.row.empty()) continue;
        TableRow row{.name = closure.row, .unit = closure.unit, .formula = closure.formula};
        if (make_row(closure_of_row(closure), table, row)) rows.push_back(std::move(row));
    }
    table.rows.insert(table.rows.end(), rows.begin(), rows.end());
}

void add_derived(Table& table) {
    const std::size_t given = table.rows.size();
    add_derived_values(table);
    const std::span<TableRow> derived = std::span(table.rows).subspan(given);
    std::vector<std::vector<std::vector<double>>> values(derived.size());  // [row][entry][draw]
    for (std::size_t r = 0; r < derived.size(); ++r) values[r].resize(derived[r].entries.size());
    for_redrawn_tables(table, all_names<Input>(), error_draws, [&](Table& drawn) {
        add_derived_values(drawn);
        for (std::size_t r = 0; r < derived.size(); ++r)
            if (const TableRow* row = find_row(drawn, derived[r].name))
                for (std::size_t i = 0; i < values[r].size(); ++i) {
                    const double value = row->entries[i].value;
                    values[r][i].push_back(std::isnan(value) ? infinite : value);  // a closure without a bound
                }
    });
    for (std::size_t r = 0; r < derived.size(); ++r)
        for (std::size_t i = 0; i < values[r].size(); ++i) {
            TableEntry& entry = derived[r].entries[i];
            if (entry.origin == Origin::missing || values[r][i].empty()) continue;
            entry.error = half_width(std::move(values[r][i]));
            if (!std::isfinite(entry.error)) entry = missing(no_value, entry.trials);
        }
}

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
