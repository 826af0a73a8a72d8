// report/tables.cpp: tables of coefficients and of sweeps for people, and as JSON.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/constants.hpp"
#include "calibrate/catalogue.hpp"
#include "report/shown.hpp"

namespace drover::report {

namespace {
using calibrate::Origin;
using calibrate::TableEntry;

struct Column {
    std::string row, heading;
};
const std::array usual_columns{Column{"drag", "alpha/Gamma"},
                               Column{"relaxation_rate", "a"},
                               Column{"weathercock", "lambda"},
                               Column{"relaxation_over_weathercock", "a/lambda"},
                               Column{"alignment", "g"},
                               Column{"propulsion", "u"},
                               Column{"damping_rate", "Gamma/(m rho)"},
                               Column{"viscosity_kinematic", "eta/(m rho)"},
                               Column{"stiffness", "E"},
                               Column{"rotational_diffusion", "D_r"},
                               Column{"bead_diffusion", "D of beads"},
                               Column{"rod_diffusion", "D of rods"},
                               Column{"contact_scattering", "c of pairs"}};

/// The usual ones that the table has, then the quantities of assays of which these show nothing.
std::vector<Column> columns_of(const calibrate::Table& table) {
    std::vector<Column> columns;
    const auto add = [&](const Column& column) {
        const calibrate::TableRow* row = calibrate::find_row(table, column.row);
        const auto is_result = [](const TableEntry& entry) { return entry.origin != Origin::set; };
        if (row != nullptr && std::ranges::any_of(row->entries, is_result)) columns.push_back(column);
    };
    for (const Column& column : usual_columns) add(column);
    const std::vector<Column> usual = columns;
    for (const calibrate::Assay& assay : calibrate::make_assays({})) {
        const auto is_of_assay = [&](const Column& column) {  // g, the row alignment, contains what that assay measures
            return column.row == assay.name ||
                   std::ranges::any_of(assay.quantities, [&](const auto& one) { return one.name == column.row; });
        };
        if (std::ranges::any_of(usual, is_of_assay)) continue;
        for (const calibrate::Quantity& quantity : assay.quantities)
            if (quantity.wanted) add({quantity.name, quantity.name});
    }
    return columns;
}

std::string cell_text(const TableEntry& entry) {
    if (entry.origin == Origin::missing) return "missing";
    return text("{}{}", measured_text_with_error(entry.value, entry.error),
                entry.origin == Origin::measured_short ? " !" : "");
}

std::string remarks_text(const calibrate::Table& table, const std::vector<Column>& columns) {
    std::string out;
    for (const calibrate::TableRow& row : table.rows) {
        if (std::ranges::none_of(columns, [&](const Column& one) { return one.row == row.name; })) continue;
        for (std::size_t i = 0; i < row.entries.size(); ++i) {
            const TableEntry& entry = row.entries[i];
            if (!calibrate::lacks_input(table, row, i) &&
                (entry.origin == Origin::missing || entry.origin == Origin::measured_short))
                out += text("{} {} at {}: {}\n", entry.origin == Origin::missing ? "missing:" : "!", row.name,
                            calibrate::point_text(table, row.by_rods, i), entry.remark);
        }
    }
    return out;
}
}  // namespace

std::string text_of(const calibrate::Table& table) {
    std::string out;
    const bool varied = !table.varied_key.empty();
    if (varied) out += text("{:>16} ", table.varied_key);
    out += text("{:>6} {:>6}", "Phi_b", "Phi_r");
    const std::vector<Column> columns = columns_of(table);
    std::vector<std::pair<const calibrate::TableRow*, std::size_t>> rows;  // with the widths of their columns
    for (const Column& column : columns) {
        const calibrate::TableRow* row = calibrate::find_row(table, column.row);
        const std::string heading = text("{} [{}]", column.heading, row->unit);
        constexpr std::size_t min_width = 21;
        rows.emplace_back(row, std::max(min_width, heading.size()));
        out += text(" {:>{}}", heading, rows.back().second);
    }
    out += '\n';
    const std::size_t rods = std::max<std::size_t>(table.rod_fractions.size(), 1), beads = table.bead_fractions.size();
    for (std::size_t point = 0; point < table.varied.size() * beads * rods; ++point) {
        if (varied) out += text("{:>16.6g} ", table.varied[point / rods / beads]);
        out += text("{:>6.4g} {:>6}", table.bead_fractions[point / rods % beads],
                    table.rod_fractions.empty() ? "-" : text("{:.4g}", table.rod_fractions[point % rods]));
        for (const auto& [row, width] : rows)
            out += text(" {:>{}}", cell_text(row->entries[row->by_rods ? point : point / rods]), width);
        out += '\n';
    }
    const std::string remarks = remarks_text(table, columns);
    return remarks.empty() ? out : out + "\n" + remarks;
}

nlohmann::json json_of(const calibrate::Table& table) {
    nlohmann::json coefficients = nlohmann::json::object();
    for (const calibrate::TableRow& row : table.rows) {
        nlohmann::json points = nlohmann::json::array();
        const std::size_t rods = row.by_rods ? table.rod_fractions.size() : 1, beads = table.bead_fractions.size();
        for (std::size_t place = 0; place < row.entries.size(); ++place) {
            const calibrate::TableEntry& known = row.entries[place];
            nlohmann::json point{{"bead_area_fraction", table.bead_fractions[place / rods % beads]},
                                 {"value", run::number_json(known.value)},
                                 {"error", run::number_json(known.error)},
                                 {"trials", known.trials},
                                 {"origin", name_of(known.origin)},
                                 {"remark", known.remark}};
            if (row.by_rods) point["rod_area_fraction"] = table.rod_fractions[place % rods];
            if (!table.varied_key.empty()) point[table.varied_key] = table.varied[place / rods / beads];
            points.push_back(std::move(point));
        }
        coefficients[row.name] = {{"unit", row.unit}, {"formula", row.formula}, {"points", std::move(points)}};
    }
    return coefficients;
}

std::string text_of(const jobs::SweepTable& table) {
    // The columns of a phase diagram; table.csv has all of them.
    std::vector<std::size_t> chosen;
    constexpr std::string_view of_order = "_susceptibility";
    for (const std::string& with : table.names) {
        if (!with.ends_with(of_order)) continue;
        const std::string order = with.substr(0, with.size() - of_order.size());
        for (const std::string& name : {order, with, order + "_binder"})
            for (std::size_t i = 0; i < table.names.size(); ++i)
                if (table.names[i] == name) chosen.push_back(i);
    }
    if (chosen.empty() ||
        table.names[chosen.front()].starts_with("size_mean_"))  // a model of its own: its patterns too
        for (std::size_t i = 0; i < table.names.size(); ++i)
            if (table.names[i].starts_with("variance_")) chosen.push_back(i);
    std::string out;
    constexpr std::size_t max_warnings = 10;  // many runs often have the same one
    for (std::size_t i = 0; i < std::min(max_warnings, table.warnings.size()); ++i)
        out += "warning: " + table.warnings[i] + "\n";
    if (table.warnings.size() > max_warnings)
        out += text("warning: {} more: with --json all are printed\n", table.warnings.size() - max_warnings);
    for (const std::string& key : table.keys) out += text("{:>20} ", key);
    out += text("{:>6} {:>5}", "branch", "seeds");
    for (const std::size_t i : chosen) out += text(" {:>26} {:>9}", table.names[i], "error");
    out += '\n';
    for (const jobs::SweepRow& row : table.rows) {
        for (const double value : row.point.values) out += text("{:>20.6g} ", value);
        out += text("{:>6} {:>5}", row.point.branch == jobs::Branch::none ? "-" : name_of(row.point.branch), row.seeds);
        for (const std::size_t i : chosen) {
            if (i >= row.results.size()) {
                out += text(" {:>26} {:>9}", "-", "-");
                continue;
            }
            const measure::Estimate& mean = row.results[i].mean;
            out += text(" {:>26} {:>9}",
                        std::isfinite(mean.mean) ? measured_text(mean.mean, mean.error.value_or(0.0)) : "-",
                        mean.error ? text("{:.2g}", *mean.error) : "-");
        }
        out += '\n';
    }
    return out;
}

nlohmann::json json_of(const jobs::SweepTable& table) {
    nlohmann::json rows = nlohmann::json::array();
    for (const jobs::SweepRow& row : table.rows) {
        nlohmann::json entry{{"seeds", row.seeds}};
        if (row.point.branch != jobs::Branch::none) entry["branch"] = name_of(row.point.branch);
        for (std::size_t k = 0; k < table.keys.size(); ++k) entry[table.keys[k]] = row.point.values[k];
        for (std::size_t i = 0; i < row.results.size(); ++i) {
            const measure::Estimate& estimate = row.results[i].mean;
            nlohmann::json result{{"mean", run::number_json(estimate.mean)},
                                  {"error", run::number_json(estimate.error.value_or(nan))},
                                  {"unit", table.units[i]}};
            if (!estimate.error) result["refusal"] = estimate.why_no_error;
            if (row.results[i].own_error) result["own_error"] = *row.results[i].own_error;
            entry[table.names[i]] = std::move(result);
        }
        rows.push_back(std::move(entry));
    }
    return rows;
}

}  // namespace drover::report
