// calibrate/redraw.cpp: tables whose numbers are drawn anew within their errors.
#include "calibrate/redraw.hpp"

#include <algorithm>
#include <limits>

#include "calibrate/closures.hpp"
#include "drover/base/random.hpp"

namespace drover::calibrate {

std::vector<Table> redrawn_tables(const Table& table, const std::vector<std::string>& rows, int count) {
    const std::vector<Uncertain> contacts = contact_alone(table);
    const auto is_wanted = [&](const std::string& name) {
        return std::find(rows.begin(), rows.end(), name) != rows.end();
    };
    Table few = table;
    std::erase_if(few.rows, [&](const TableRow& row) {
        return !is_wanted(row.name) && !row.name.starts_with("alignment_") && !row.name.starts_with("contact_") &&
               row.name != straight_drag;
    });
    std::vector<Table> tables;
    for (int number = 0; number < count; ++number) {
        Table& redrawn = tables.emplace_back(few);
        std::vector<double> normal;
        const auto draw = [&](std::size_t row, std::size_t size) {
            normal.resize(size);
            RandomKey key{.seed = static_cast<std::uint64_t>(number), .stream = Stream::bootstrap};
            key.substep = static_cast<std::uint32_t>(row);
            fill_normal(key, 0, 1, normal);
        };
        for (std::size_t r = 0; r < redrawn.rows.size(); ++r) {
            TableRow& row = redrawn.rows[r];
            if (row.name == row_name(contact) || !is_wanted(row.name)) continue;
            draw(r, row.entries.size());
            for (std::size_t i = 0; i < normal.size(); ++i) row.entries[i].value += normal[i] * row.entries[i].error;
        }
        const std::vector<Uncertain> derived = contact_alone(redrawn);
        draw(redrawn.rows.size(), derived.size());
        for (TableRow& row : redrawn.rows)
            for (std::size_t i = 0; row.name == row_name(contact) && i < derived.size(); ++i)
                row.entries[i].value = derived[i].value + normal[i] * contacts[i].error;
    }
    return tables;
}

std::array<double, 3> quantiles_of(std::vector<double> values) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    if (values.empty()) return {none, none, none};
    std::sort(values.begin(), values.end());
    const auto at = [&](double part) { return values[static_cast<std::size_t>(part * double(values.size() - 1))]; };
    return {at(0.16), at(0.5), at(0.84)};
}

}  // namespace drover::calibrate
