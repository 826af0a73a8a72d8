// calibrate/table.cpp: indices of a table, its checks, and its coefficients as smooth functions.
#include "calibrate/table.hpp"

#include <algorithm>
#include <cmath>

#include "base/mapped.hpp"

namespace drover::calibrate {

std::size_t count_of(const Table& table, bool by_rods) {
    return table.varied.size() * table.bead_fractions.size() * (by_rods ? table.rod_fractions.size() : 1);
}

std::size_t entry_index(const Table& table, const TableRow& row, std::size_t varied, std::size_t bead,
                        std::size_t rod) {
    const std::size_t point = varied * table.bead_fractions.size() + bead;
    return row.by_rods ? point * table.rod_fractions.size() + rod : point;
}

std::string point_text(const Table& table, bool by_rods, std::size_t entry) {
    const std::size_t rods = by_rods ? table.rod_fractions.size() : 1, beads = table.bead_fractions.size();
    std::string point = text("bead area fraction {}", table.bead_fractions[entry / rods % beads]);
    if (by_rods) point += text(", rod area fraction {}", table.rod_fractions[entry % rods]);
    if (!table.varied_key.empty()) point += text(", {} = {}", table.varied_key, table.varied[entry / rods / beads]);
    return point;
}

std::size_t varied_index(const Table& table, const std::optional<double>& value, const std::string& name,
                         const SourceLocation& where) {
    if (table.varied_key.empty()) {
        require(!value, where, "{} = {}, but the table varies no key; expected no {}", name, value.value_or(0.0), name);
        return 0;
    }
    const std::vector<std::string> values = mapped(table.varied, [](double one) { return text("{}", one); });
    require(value.has_value(), where, "the table also varies {}; expected {} with one of {}", table.varied_key, name,
            joined(values));
    const auto found = std::ranges::find(table.varied, *value);
    require(found != table.varied.end(), where,
            "{} = {}; the table varies {}: expected one of {} (there is no interpolation between them)", name, *value,
            table.varied_key, joined(values));
    return static_cast<std::size_t>(found - table.varied.begin());
}

namespace {
void check_fractions(const std::vector<double>& fractions, const char* name, const SourceLocation& where) {
    for (std::size_t i = 0; i < fractions.size(); ++i)
        require(fractions[i] > 0.0 && fractions[i] < 1.0 && (i == 0 || fractions[i] > fractions[i - 1]), where,
                "{}: value {} is {}; expected ascending area fractions between 0 and 1", name, i + 1, fractions[i]);
}

void check_entry(const Table& table, const TableRow& row, std::size_t index, const SourceLocation& where) {
    const TableEntry& entry = row.entries[index];
    if (entry.origin == Origin::missing) return;
    const auto at = [&] { return point_text(table, row.by_rods, index); };
    require(std::isfinite(entry.value), where,
            "{} at {} is {}; expected a finite number, since its origin is not \"missing\"", row.name, at(),
            entry.value);
    require(entry.error >= 0.0 && std::isfinite(entry.error), where,
            "{} at {} has the standard error {}; expected a number >= 0", row.name, at(), entry.error);
    require(entry.trials >= 0, where, "{} at {} has {} trials; expected 0 or more", row.name, at(), entry.trials);
}

const TableRow& complete_row(const Table& table, const std::string& name, std::size_t varied) {
    const std::vector<std::string> names = mapped(table.rows, &TableRow::name);
    const TableRow* row = find_row(table, name);
    if (row == nullptr)
        fail_input({}, "the table has no coefficient {}; {}", name,
                   suggestion(name, names, text("expected one of {}", joined(names))));
    require(varied < table.varied.size(), {}, "index {} of {} is out of range; expected an index below {}", varied,
            table.varied_key.empty() ? "a key that the table does not vary" : table.varied_key, table.varied.size());
    const std::size_t count = row->entries.size() / table.varied.size();
    for (std::size_t i = varied * count; i < (varied + 1) * count; ++i) {
        const TableEntry& entry = row->entries[i];
        require(
            entry.origin != Origin::missing, {},
            "the table has no value of {} at {} ({}); expected values at all points: measure it, or remove this point "
            "from the scene",
            name, point_text(table, row->by_rods, i), entry.remark);
    }
    return *row;
}

numerics::SplineTable smooth_table(const Table& table, const TableRow& row, std::size_t varied,
                                   numerics::Outside outside) {
    const std::size_t count = row.entries.size() / table.varied.size();
    std::vector<double> values, errors;
    for (std::size_t i = varied * count; i < (varied + 1) * count; ++i) {
        values.push_back(row.entries[i].value);
        errors.push_back(row.entries[i].error);
    }
    return {table.bead_fractions, row.by_rods ? table.rod_fractions : std::vector<double>{0.0}, values, outside,
            errors};
}
}  // namespace

void check(const Table& table, const SourceLocation& where) {
    require(!table.bead_fractions.empty(), where, "bead_area_fraction is empty; expected at least one value");
    check_fractions(table.bead_fractions, "bead_area_fraction", where);
    check_fractions(table.rod_fractions, "rod_area_fraction", where);
    require(!table.varied.empty(), where, "{} has no values; expected at least one", table.varied_key);
    for (const double value : table.varied)
        require(std::isfinite(value), where, "{} has the value {}; expected finite numbers", table.varied_key, value);
    for (const TableRow& row : table.rows) {
        require(row.entries.size() == count_of(table, row.by_rods) && !row.entries.empty(), where,
                "{} has {} numbers; expected {}", row.name, row.entries.size(), count_of(table, row.by_rods));
        for (std::size_t i = 0; i < row.entries.size(); ++i) check_entry(table, row, i, where);
    }
}

SmoothCoefficient::SmoothCoefficient(const Table& table, const std::string& name, std::size_t varied,
                                     numerics::Outside outside)
    : name_(name),
      beads_(table.bead_fractions),
      rods_(table.rod_fractions),
      by_rods_(complete_row(table, name, varied).by_rods),
      outside_(outside),
      table_(smooth_table(table, *find_row(table, name), varied, outside)) {}

Uncertain SmoothCoefficient::at(double bead_fraction, double rod_fraction) const {
    const auto check_inside = [&](const char* kind, const std::vector<double>& axis, double fraction) {
        constexpr double rounding = 1e-12;
        const bool inside = fraction >= axis.front() - rounding && fraction <= axis.back() + rounding;
        require(std::isfinite(fraction) && (inside || outside_ == numerics::Outside::hold), {},
                "{} at a {} area fraction of {}: the table covers {} to {}; expected a value within it: measure there, "
                "or use "
                "the value at the edge (calibrated.outside = \"hold\" in the scene)",
                name_, kind, fraction, axis.front(), axis.back());
    };
    check_inside("bead", beads_, bead_fraction);
    bead_fraction = std::clamp(bead_fraction, beads_.front(), beads_.back());
    if (by_rods_) {
        check_inside("rod", rods_, rod_fraction);
        rod_fraction = std::clamp(rod_fraction, rods_.front(), rods_.back());
    }
    return {.value = table_.at(bead_fraction, rod_fraction).value,
            .error = table_.standard_error(bead_fraction, rod_fraction)};
}

}  // namespace drover::calibrate
