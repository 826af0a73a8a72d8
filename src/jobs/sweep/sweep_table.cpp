// jobs/sweep/sweep_table.cpp: means over seeds, and where they contradict the errors of the runs; the table as CSV.
#include "jobs/sweep/sweep_plan.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "measure/trajectories.hpp"

namespace drover::jobs {

namespace {
/// The mean over the seeds of a point.
measure::Replicates over_seeds(const std::vector<measure::Estimate>& runs) {
    if (!runs.empty()) return measure::combine(runs);
    return {.mean = {.mean = nan, .why_no_error = "no run of this point has this observable"},
            .deviation = nan,
            .chi_squared = nan,
            .chance = nan};
}

/// The relaxation time of a point is the inverse of its mean rotational diffusion: the inverse of a single short run is
/// too noisy.
void invert_diffusion(const std::vector<std::string>& names, std::vector<measure::Replicates>& results) {
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    const std::size_t from = column("rotational_diffusion"), to = column("relaxation_time");
    if (from >= results.size() || to >= results.size()) return;
    results[to].mean = measure::relaxation_time_of(results[from].mean);
}

/// Warns of errors that the scatter of the seeds does not show, or that contradict it.
void add_warnings(const SweepRow& row, bool finds_warm_up, SweepTable& table) {
    std::vector<std::string> wide, narrow, unknown;
    for (std::size_t column = 0; column < row.results.size(); ++column) {
        const measure::Replicates& result = row.results[column];
        const std::string& name = table.names[column];
        if (measure::contradicts(result)) (result.chi_squared > 1.0 ? wide : narrow).push_back(name);
        // Components of a direction wander, and have no start to forget.
        const bool wanders =
            result.mean.averaging == measure::Averaging::direction || name.ends_with("_x") || name.ends_with("_y");
        if (finds_warm_up && row.seeds > 1 && result.mean.error && result.without_error > 0 && !wanders)
            unknown.push_back(name);
    }
    std::string at;
    for (std::size_t k = 0; k < row.point.values.size(); ++k)
        at += text("{}{} = {:.6g}", k == 0 ? "at " : ", ", table.keys[k], row.point.values[k]);
    if (!at.empty()) at += ": ";
    if (!wide.empty())
        table.warnings.push_back(
            text("{}the seeds differ by far more than their errors in {}; the runs are shorter than their slowest "
                 "change, or end in different states: give longer runs; the error in the table is that of the scatter",
                 at, joined(wide)));
    if (constexpr std::size_t max_names = 4; !unknown.empty()) {
        const std::size_t shown = std::min(unknown.size(), max_names), more = unknown.size() - shown;
        unknown.resize(shown);
        table.warnings.push_back(
            text("{}some runs are too short for an error estimate in {}{}; the error in the table is that of "
                 "the scatter, which does not show what the runs have in common, such as their start: give longer "
                 "runs, or set analysis.warm_up",
                 at, joined(unknown), more == 0 ? "" : text(" and {} more", more)));
    }
    if (!narrow.empty())
        table.warnings.push_back(
            text("{}the seeds differ by far less than their errors in {}; the error in the "
                 "table is that of the scatter",
                 at, joined(narrow)));
}
}  // namespace

SweepTable sweep_table(const SweepLayout& layout, const std::map<std::string, RunResults>& results) {
    SweepTable table{.keys = layout.keys, .names = {}, .units = {}, .rows = {}};
    std::vector<std::vector<std::vector<measure::Estimate>>> found(layout.points.size());  // [point][observable][seed]
    std::vector<int> seeds(layout.points.size(), 0);
    for (const SweepRun& run : layout.runs) {
        const auto ended = results.find(run.name);
        if (ended == results.end()) continue;
        ++seeds[run.point];
        for (const std::string& warning : ended->second.warnings) table.warnings.push_back(run.name + ": " + warning);
        for (const measure::SummaryRow& row : ended->second.rows) {
            if (!row.axes.empty()) continue;
            // By name: runs may differ in their observables, such as those of beads.
            const auto named = std::ranges::find(table.names, row.name);
            const auto column = static_cast<std::size_t>(named - table.names.begin());
            if (named == table.names.end()) {
                table.names.push_back(row.name);
                table.units.push_back(row.unit);
            }
            if (found[run.point].size() <= column) found[run.point].resize(column + 1);
            found[run.point][column].push_back(row.estimates.front());
        }
    }
    for (std::size_t point = 0; point < layout.points.size(); ++point) {
        SweepRow row{.point = layout.points[point], .seeds = seeds[point], .results = {}};
        if (row.seeds > 0) found[point].resize(table.names.size());
        for (const auto& runs : found[point]) row.results.push_back(over_seeds(runs));
        add_warnings(row, layout.finds_warm_up, table);
        invert_diffusion(table.names, row.results);
        table.rows.push_back(std::move(row));
    }
    return table;
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
        if (row.results.empty()) out.append(3 * table.names.size(), ',');  // no run of the point has ended
        out += '\n';
    }
    return out;
}

}  // namespace drover::jobs
