// calibrate/table_derived.cpp: rows that follow from measured rows, at each point of a table.
#include <algorithm>
#include <cmath>
#include <span>

#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/closures.hpp"
#include "calibrate/redraw.hpp"

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

}  // namespace drover::calibrate
