// report/sweep_table.cpp: the table of a sweep for people, and as JSON.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/constants.hpp"
#include "report/shown.hpp"

namespace drover::report {

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
            out += text(" {:>26} {:>9}", measured_text(mean.mean, mean.error.value_or(0.0)),
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
