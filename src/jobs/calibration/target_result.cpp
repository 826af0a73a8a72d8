// jobs/calibration/target_result.cpp: wanted numbers of a calibration and what they rest on, as a result.
#include <algorithm>

#include "base/constants.hpp"
#include "jobs/calibration/target_plan.hpp"

namespace drover::jobs {

namespace {
/// Infinity is for places beyond the table.
double finite_or_none(double value) { return std::isfinite(value) ? value : nan; }

run::List value_list(const TargetPlan& plan) {
    run::List list{.name = "numbers",
                   .heading = "wanted numbers",
                   .row = "wanted",
                   .meaning = "wanted number",
                   .has_like_rows = false};
    for (const TargetProgress& value : plan.values()) {
        const calibrate::TargetResult& result = value.result;
        list.rows.push_back(
            {.entries = {run::words("number", "what is wanted", value.text),
                         run::number("value", "", "of the table", finite_or_none(result.value), 4),
                         run::number("error", "",
                                     "standard error: half of the distance from 16 to 84 % of redrawn tables, enlarged "
                                     "by what few trials leave uncertain in it",
                                     finite_or_none(value.cautious_error), 2),
                         run::number("wanted_error", "", "error to reach", finite_or_none(result.allowed), 2),
                         run::flag("reached", "whether it is", value.reached),
                         run::words("note", "why it was not reached", value.note)}});
    }
    return list;
}

/// Largest part of what the measurements of c differ by in the variance of a wanted number.
double largest_disagreement(const TargetPlan& plan) {
    double largest = 0.0;
    for (const TargetProgress& value : plan.values()) largest = std::max(largest, value.result.disagreement);
    return largest;
}

/// A part of the variances.
run::Record part_row(const char* name, const char* meaning, const std::string& what, double part, double trials,
                     double seconds) {
    return {.entries = {run::words(name, meaning, what),
                        run::number("percentage", "percent", "of the variance of a wanted number", 100.0 * part, 3),
                        run::number("trials", "1", "that have run", trials, 6),
                        run::number("core_seconds", "s", "of the trials whose time is known", seconds, 4)}};
}

/// That which no trial reduces.
run::Record disagreement_row(const char* name, const char* meaning, double part) {
    return part_row(name, meaning, "the measurements of c differ by more than their errors", part, nan, nan);
}

/// Parts of one unit in the variances of the wanted numbers.
struct ErrorPart {
    std::size_t unit = 0;
    double largest = 0.0;
};

run::List part_list(const CalibrationLayout& layout, const TargetPlan& plan, const std::vector<UnitProgress>& units) {
    run::List list{.name = "measurements",
                   .heading =
                       "\nparts of the variance, the largest first (of several wanted numbers: where it is largest)",
                   .row = "measurement",
                   .meaning = "assay at a point"};
    std::vector<ErrorPart> parts;
    for (std::size_t u = 0; u < units.size(); ++u) {
        if (!plan.needs(u)) continue;
        parts.push_back({.unit = u});
        for (const TargetProgress& value : plan.values())
            if (u < value.result.parts.size())
                parts.back().largest = std::max(parts.back().largest, value.result.parts[u]);
    }
    std::ranges::stable_sort(parts, [](const ErrorPart& a, const ErrorPart& b) { return a.largest > b.largest; });
    for (const auto& [u, largest] : parts)
        list.rows.push_back(part_row("measurement", "assay and point", layout.units[u].name, largest,
                                     static_cast<double>(units[u].trials->count()), units[u].trials->core_seconds()));
    if (const double part = largest_disagreement(plan); part > 0.0)
        list.rows.insert(std::ranges::find_if(parts, [&](const ErrorPart& one) { return one.largest < part; }) -
                             parts.begin() + list.rows.begin(),
                         disagreement_row("measurement", "assay and point", part));
    return list;
}

run::List assay_list(const CalibrationLayout& layout, const TargetPlan& plan, const std::vector<UnitProgress>& units) {
    run::List list{.name = "assays", .heading = "\nby assay", .row = "assay", .meaning = "assay"};
    for (std::size_t a = 0; a < layout.assays.size(); ++a) {
        double seconds = 0.0, trials = 0.0, largest = 0.0;
        for (const TargetProgress& value : plan.values()) {
            double sum = 0.0;
            for (std::size_t u = 0; u < value.result.parts.size(); ++u)
                if (layout.units[u].assay == a) sum += value.result.parts[u];
            largest = std::max(largest, sum);
        }
        for (std::size_t u = 0; u < units.size(); ++u)
            if (layout.units[u].assay == a) {
                seconds += units[u].trials->core_seconds();
                trials += static_cast<double>(units[u].trials->count());
            }
        list.rows.push_back(part_row("assay", "name", layout.assays[a].name, largest, trials, seconds));
    }
    if (const double part = largest_disagreement(plan); part > 0.0)
        list.rows.push_back(disagreement_row("assay", "name", part));
    return list;
}
}  // namespace

run::Result target_result(const CalibrationLayout& layout, const TargetPlan& plan,
                          const std::vector<UnitProgress>& units) {
    double seconds = 0.0;
    for (const UnitProgress& unit : units) seconds += unit.trials->core_seconds();
    run::Record root{.lists = {value_list(plan), part_list(layout, plan, units), assay_list(layout, plan, units)}};
    root.entries.push_back(run::number("core_seconds", "s", "of all trials whose time is known", seconds, 4));
    return {.root = std::move(root)};
}

}  // namespace drover::jobs
