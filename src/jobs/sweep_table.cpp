// jobs/sweep_table.cpp: the table of a sweep as text.
#include "jobs/sweep_table.hpp"

#include <algorithm>

#include "drover/base/text.hpp"

namespace drover::jobs {

std::string table_text(const SweepTable& table) {
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
    for (const SweepRow& row : table.rows) {
        for (const double value : row.point.values) out += text("{:>20.6g} ", value);
        out += text("{:>6} {:>5}", row.point.branch.empty() ? "-" : row.point.branch, row.seeds);
        for (const std::size_t i : chosen) {
            if (i >= row.results.size()) {
                out += text(" {:>26} {:>9}", "-", "-");
                continue;
            }
            const measure::Estimate& mean = row.results[i].mean;
            out += text(" {:>26} {:>9}", measured_text(mean.mean, mean.error.value_or(0.0)),
                        mean.error ? text("{:.2g}", *mean.error) : "-");
        }
        out += '\n';
    }
    return out;
}

std::string table_csv(const SweepTable& table) {
    std::string out;
    for (const std::string& key : table.keys) out += key + ",";
    out += "branch,seeds";
    for (std::size_t i = 0; i < table.names.size(); ++i)
        out += text(",{0} [{1}],{0} error,{0} own error", table.names[i], table.units[i]);
    out += '\n';
    for (const SweepRow& row : table.rows) {
        for (const double value : row.point.values) out += text("{},", value);
        out += text("{},{}", row.point.branch, row.seeds);
        const auto number = [](const std::optional<double>& value) { return value ? text("{}", *value) : ""; };
        for (const measure::Replicates& result : row.results)
            out += text(",{},{},{}", result.mean.mean, number(result.mean.error), number(result.own_error));
        out += '\n';
    }
    return out;
}

}  // namespace drover::jobs
