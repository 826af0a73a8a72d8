// jobs/calibration/target_plan.cpp: wanted numbers as entries of a table, the trials that they still need, and what
// they rest on, as a result.
#include "jobs/calibration/target_plan.hpp"

#include <algorithm>
#include <set>

#include "base/constants.hpp"
#include "base/mapped.hpp"

namespace drover::jobs {

namespace {
using calibrate::Table;
using calibrate::TableTarget;
using calibrate::TrialSet;

/// Trials of every needed unit before anything is known, and of those that may make this part of a variance.
constexpr std::size_t pilot_trials = 4, relevant_trials = measure::min_blocks;
constexpr double relevant_part = 0.03;
/// Errors count as larger by this many of their own standard errors, and slopes of the excess as smaller.
constexpr double margin = 1.0;
/// A variance that few trials make too small by chance must not keep its unit from more: for the choice of the next
/// trials it counts as larger by this many of its relative standard errors.
constexpr double caution = 1.5;
/// Core seconds of the next trials, as a fraction of those spent: what is known of scatter and slopes still changes.
constexpr double growth = 0.25;

/// By how much a variance may be larger than these trials show.
double caution_of(std::size_t trials) {
    return trials > 1 ? std::exp(caution * std::sqrt(2.0 / (static_cast<double>(trials) - 1.0))) : 1.0;
}

/// The axis of the table that a range is of; nullptr if there is none.
const std::vector<double>* find_axis(const Table& table, const std::string& name) {
    if (name == "Phi_b" || name == "bead_area_fraction") return &table.bead_fractions;
    if (name == "Phi_r" || name == "rod_area_fraction") return &table.rod_fractions;
    return !table.varied_key.empty() && name == table.varied_key ? &table.varied : nullptr;
}

bool is_selected(const AccuracyTarget& target, const Table& table, const std::vector<double>& axis, std::size_t index) {
    return std::ranges::all_of(target.ranges, [&](const AxisRange& range) {
        return find_axis(table, range.axis) != &axis || range.holds(axis[index]);
    });
}

std::string text_of(const TableTarget& in_table, const Table& table) {
    if (!in_table.row.empty()) {
        const calibrate::TableRow& row = *calibrate::find_row(table, in_table.row);
        return text("{} at {}", row.name,
                    calibrate::point_text(table, row.by_rods,
                                          calibrate::entry_index(table, row, in_table.varied, in_table.bead,
                                                                 in_table.rod)));
    }
    std::string point = text("onset at rod area fraction {}", table.rod_fractions[in_table.rod]);
    if (!table.varied_key.empty()) point += text(", {} = {}", table.varied_key, table.varied[in_table.varied]);
    return point;
}

std::vector<std::string> measured_rows(const CalibrationLayout& layout) {
    std::vector<std::string> rows;
    for (const calibrate::Assay& assay : layout.assays)
        for (const calibrate::Quantity& quantity : assay.quantities) rows.push_back(quantity.name);
    return rows;
}

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

TargetPlan::TargetPlan(const CalibrationLayout& layout, const std::vector<AccuracyTarget>& targets,
                       const TargetLimits& limits)
    : layout_(layout), limits_(limits), setup_(layout.axes), sources_(layout.units.size()) {
    add_setup_rows(layout, setup_);
    for (const CalibrationUnit& unit : layout.units)
        ended_.emplace_back(layout.assays[unit.assay], TrialSet::no_goal(), 0.0);
    Table whole = setup_;  // for the names of its rows
    add_measured_rows(layout, ended_, whole);
    calibrate::add_derived_values(whole);
    for (const AccuracyTarget& target : targets) add_targets(target, whole);
}

void TargetPlan::add_targets(const AccuracyTarget& target, const Table& whole) {
    const SourceLocation where{.file = "--want " + target.text};
    for (const AxisRange& range : target.ranges)
        require(find_axis(layout_.axes, range.axis) != nullptr, where,
                "the table has no axis \"{}\"; expected Phi_b, Phi_r{}", range.axis,
                layout_.axes.varied_key.empty() ? "" : " or " + layout_.axes.varied_key);
    TableTarget in_table{.error = target.error, .is_relative = target.is_relative};
    if (target.observable != "onset") in_table.row = target.observable == "g" ? "alignment" : target.observable;
    try {
        calibrate::inputs_of(in_table, measured_rows(layout_));
    } catch (const Error& error) {
        fail_input(where, "{}", error.what());
    }
    const calibrate::TableRow* row = calibrate::find_row(whole, in_table.row);
    const bool is_onset = in_table.row.empty();
    require(is_onset || row != nullptr, where, "the table of this scene has no {}", in_table.row);
    require_plausible(target, is_onset ? "1" : row->unit);
    const Table& axes = layout_.axes;
    require(!is_onset || (axes.bead_fractions.size() > 1 && !axes.rod_fractions.empty()), where,
            "{} area fractions of beads and {} of rods; an onset needs at least two of beads and one of rods",
            axes.bead_fractions.size(), axes.rod_fractions.size());
    const std::size_t beads = is_onset ? 1 : axes.bead_fractions.size();
    const bool by_rods = is_onset || row->by_rods;
    const std::size_t rods = by_rods ? axes.rod_fractions.size() : 1, before = values_.size();
    for (in_table.varied = 0; in_table.varied < axes.varied.size(); ++in_table.varied)
        for (in_table.bead = 0; in_table.bead < beads; ++in_table.bead)
            for (in_table.rod = 0; in_table.rod < rods; ++in_table.rod) {
                const bool in = is_selected(target, axes, axes.varied, in_table.varied) &&
                                (is_onset || is_selected(target, axes, axes.bead_fractions, in_table.bead)) &&
                                (!by_rods || is_selected(target, axes, axes.rod_fractions, in_table.rod));
                if (!in) continue;
                values_.push_back({.in_table = in_table, .text = text_of(in_table, whole), .result = {}, .note = {}});
                find_needed(in_table, whole);
            }
    require(values_.size() > before, where, "no point of the table is in this range; it has Phi_b = {} and Phi_r = {}",
            toml_text(axes.bead_fractions), toml_text(axes.rod_fractions));
}

void TargetPlan::find_needed(const TableTarget& in_table, const Table& whole) {
    const std::vector<std::string> inputs = calibrate::inputs_of(in_table, measured_rows(layout_));
    const bool by_rods = in_table.row.empty() || calibrate::find_row(whole, in_table.row)->by_rods;
    // Contacts are measured at all area fractions of rods together.
    const bool is_pooled = std::ranges::find(inputs, "alignment_reference") != inputs.end() ||
                           std::ranges::find(inputs, "contact_reference") != inputs.end();
    for (std::size_t u = 0; u < layout_.units.size(); ++u) {
        const CalibrationUnit& unit = layout_.units[u];
        const calibrate::Assay& assay = layout_.assays[unit.assay];
        const bool is_elsewhere = unit.bead != in_table.bead || (by_rods && !is_pooled && unit.rod != in_table.rod &&
                                                                 assay.population == calibrate::Population::all);
        if (unit.varied != in_table.varied || (is_elsewhere && !in_table.row.empty())) continue;
        for (const calibrate::Quantity& quantity : assay.quantities) {
            const calibrate::TableRow row{.name = quantity.name,
                                          .by_rods = assay.population == calibrate::Population::all};
            const calibrate::EntryPlace place{row.name, calibrate::entry_index(layout_.axes, row, unit.varied,
                                                                               unit.bead, unit.rod)};
            if (std::ranges::count(inputs, row.name) > 0 && std::ranges::count(sources_[u], place) == 0)
                sources_[u].push_back(place);
        }
    }
}

bool TargetPlan::lacks_trials(std::size_t unit, const UnitProgress& progress) const {
    constexpr std::size_t few_failures = 3;
    const bool fails = progress.trials->failed() >= few_failures && ended_[unit].failure_reason();
    return needs(unit) && !progress.has_crashed && !fails && progress.given < limits_.max_trials;
}

void TargetPlan::evaluate_targets(const std::vector<UnitProgress>& units) {
    Table table = setup_;
    add_measured_rows(layout_, ended_, table);
    auto results = calibrate::evaluate(mapped(values_, &TargetProgress::in_table), table, sources_);
    for (std::size_t k = 0; k < values_.size(); ++k) {
        TargetProgress& value = values_[k];
        value.result = std::move(results[k]);
        // Welch and Satterthwaite: the variance is a sum of variances, each known from few trials.
        double squares = 0.0;
        for (std::size_t u = 0; u < units.size(); ++u)
            if (const double part = value.result.parts[u]; part > 0.0)
                squares += part * part / (static_cast<double>(ended_[u].measurement()->trials) - 1.0);
        value.variance_error = std::sqrt(2.0 * squares);
        // The slope may be smaller than it seems.
        const double slope = std::max(1.0 - margin * value.result.slope_error, 1e-3);
        value.cautious_error = value.result.error * (1.0 + 0.5 * margin * value.variance_error) / slope;
        value.reached = !value.result.missing && std::isfinite(value.cautious_error) &&
                        value.cautious_error <= value.result.allowed;
        value.note = value.reached ? "" : note_on(value, units);
    }
}

bool TargetPlan::is_spent(const std::vector<UnitProgress>& units) const {
    double spent = 0.0;
    for (const UnitProgress& unit : units) spent += unit.trials->core_seconds();
    return spent >= limits_.budget;
}

std::string TargetPlan::note_on(const TargetProgress& value, const std::vector<UnitProgress>& units) const {
    if (value.result.missing && !is_spent(units)) return *value.result.missing;
    if (value.result.is_beyond)
        return text("flocks begin {} the table; add area fractions to calibrate.bead_area_fractions",
                    value.result.value > 0.0 ? "above" : "below");
    if (value.fixed_variance() >= 1.0)
        return "the measurements of contact_alignment differ by more than this error allows, which no number of trials "
               "changes; allow a larger one";
    if (is_spent(units)) return "the budget is spent; give a larger one";
    for (std::size_t u = 0; u < units.size(); ++u)
        if (value.result.parts[u] > 0.0 && units[u].given >= limits_.max_trials)
            return text("{} has had calibrate.max_trials = {} trials; give more", layout_.units[u].name,
                        limits_.max_trials);
    return "not finished";
}

std::vector<double> TargetPlan::seconds_each(const std::vector<UnitProgress>& units) const {
    std::vector<double> sums(layout_.assays.size() + 1, 0.0), counts(layout_.assays.size() + 1, 0.0);
    for (std::size_t u = 0; u < units.size(); ++u)
        for (const std::size_t of : {layout_.units[u].assay, layout_.assays.size()}) {
            sums[of] += units[u].trials->core_seconds();
            counts[of] += static_cast<double>(units[u].trials->timed());
        }
    std::vector<double> seconds;
    for (std::size_t u = 0; u < units.size(); ++u) {
        const std::size_t assay = layout_.units[u].assay, all = layout_.assays.size();
        const TrialSet& trials = *units[u].trials;
        if (trials.timed() > 0) seconds.push_back(trials.core_seconds() / static_cast<double>(trials.timed()));
        else if (counts[assay] > 0.0) seconds.push_back(sums[assay] / counts[assay]);
        else seconds.push_back(counts[all] > 0.0 ? sums[all] / counts[all] : 1.0);
    }
    return seconds;
}

bool TargetPlan::add_for_relevant(const std::vector<UnitProgress>& units, std::vector<std::uint64_t>& needed) const {
    bool any = false;
    for (std::size_t u = 0; u < units.size(); ++u) {
        const std::size_t trials = ended_[u].successful().size();
        double part = 0.0;
        for (const TargetProgress& value : values_) part = std::max(part, value.result.parts[u]);
        if (part * caution_of(trials) < relevant_part || trials >= relevant_trials || !lacks_trials(u, units[u]))
            continue;
        const std::uint64_t wanted =
            std::min<std::uint64_t>(relevant_trials + units[u].trials->failed(), limits_.max_trials);
        needed[u] = std::max(needed[u], wanted);
        any = any || needed[u] > units[u].trials->count();
    }
    return any;
}

void TargetPlan::add_for_missing(const std::vector<UnitProgress>& units, std::vector<std::uint64_t>& needed) const {
    const auto half_more = [&](std::size_t u) {
        return std::min<std::uint64_t>(limits_.max_trials, units[u].given + units[u].given / 2 + 1);
    };
    bool all_complete = true, all_ended = true;
    for (std::size_t u = 0; u < units.size(); ++u) {
        const bool is_complete = ended_[u].has_result();
        const bool waits = units[u].given > units[u].trials->count();
        all_complete = all_complete && (is_complete || !needs(u));
        all_ended = all_ended && !waits;
        if (!is_complete && !waits && lacks_trials(u, units[u])) needed[u] = half_more(u);
    }
    const bool is_unclear =
        std::ranges::any_of(values_, [](const TargetProgress& value) { return value.result.missing.has_value(); });
    if (!is_unclear || !all_complete || !all_ended) return;
    for (std::size_t u = 0; u < units.size(); ++u)  // a divisor may be within its error of 0
        if (lacks_trials(u, units[u])) needed[u] = half_more(u);
}

void TargetPlan::add_for_errors(const std::vector<UnitProgress>& units, std::vector<std::uint64_t>& needed) const {
    const std::vector<double> seconds = seconds_each(units);
    double spent = 0.0, longest = 0.0;
    std::vector<calibrate::TrialCosts> costs;
    for (std::size_t u = 0; u < units.size(); ++u) {
        const auto done = static_cast<double>(ended_[u].successful().size());
        const auto running = static_cast<double>(units[u].given - units[u].trials->count());
        calibrate::TrialCosts cost{.trials = static_cast<std::size_t>(std::max(done + running, 1.0)),
                                   .seconds = seconds[u]};
        cost.max_trials = lacks_trials(u, units[u]) ? cost.trials + limits_.max_trials - units[u].given : 0;
        cost.caution = caution_of(ended_[u].successful().size());
        for (const TargetProgress& value : values_) {
            constexpr double unknown = 4.0;  // of an onset that may lie beyond the table: look again soon
            const double fixed = value.fixed_variance();
            const bool is_open = !value.reached && !value.result.is_beyond && !value.result.missing && fixed < 1.0;
            const double ratio =
                (std::isfinite(value.cautious_error) ? std::pow(value.cautious_error / value.result.allowed, 2)
                                                     : unknown) /
                (1.0 - fixed);
            const double kept = done > 0.0 ? done / (done + running) : 0.0;
            cost.variances.push_back(is_open ? ratio * value.result.parts[u] * kept : 0.0);
        }
        spent += seconds[u] * (done + running);
        if (needs(u)) longest = std::max(longest, seconds[u]);
        costs.push_back(std::move(cost));
    }
    if (spent >= limits_.budget) return;
    const double allowed = std::max(growth * spent, longest * static_cast<double>(limits_.workers));
    const std::vector<std::size_t> added = calibrate::allocate(costs, std::min(allowed, limits_.budget - spent));
    for (std::size_t u = 0; u < units.size(); ++u) needed[u] = std::max(needed[u], units[u].given + added[u]);
}

std::vector<std::uint64_t> TargetPlan::next(const std::vector<UnitProgress>& units) {
    std::vector<std::uint64_t> needed;
    bool is_pilot = false;
    const bool spent = is_spent(units);
    for (std::size_t u = 0; u < units.size(); ++u) {
        const TrialSet& trials = *units[u].trials;
        if (trials.successful().size() != ended_[u].successful().size() || trials.failed() != ended_[u].failed()) {
            ended_[u] = trials;
            ended_[u].take_all();
        }
        const std::uint64_t first = pilot_trials + trials.failed();
        const bool lacks = !spent && lacks_trials(u, units[u]) && trials.successful().size() < pilot_trials;
        needed.push_back(lacks ? std::min<std::uint64_t>(std::max(units[u].given, first), limits_.max_trials)
                               : units[u].given);
        is_pilot = is_pilot || (lacks && needed.back() > trials.count());
    }
    if (is_pilot) return needed;
    evaluate_targets(units);
    if (add_for_relevant(units, needed)) return needed;
    const bool is_done = std::ranges::all_of(values_, [](const TargetProgress& value) {
        return value.reached || (!value.result.missing && value.result.is_beyond);
    });
    if (is_done || spent) return needed;
    add_for_missing(units, needed);
    add_for_errors(units, needed);
    return needed;
}

std::vector<std::string> needed_assays(const CalibrationLayout& layout, const std::vector<AccuracyTarget>& targets) {
    const TargetPlan plan(layout, targets, {});
    std::set<std::size_t> needed;
    for (std::size_t u = 0; u < layout.units.size(); ++u)
        if (plan.needs(u)) needed.insert(layout.units[u].assay);
    return mapped(needed, [&](std::size_t assay) { return layout.assays[assay].name; });
}

run::Result target_result(const CalibrationLayout& layout, const TargetPlan& plan,
                          const std::vector<UnitProgress>& units) {
    double seconds = 0.0;
    for (const UnitProgress& unit : units) seconds += unit.trials->core_seconds();
    run::Record root{.lists = {value_list(plan), part_list(layout, plan, units), assay_list(layout, plan, units)}};
    root.entries.push_back(run::number("core_seconds", "s", "of all trials whose time is known", seconds, 4));
    return {.root = std::move(root)};
}

}  // namespace drover::jobs
