// calibrate/target.cpp: errors of targets from redrawn measurements, and the choice of the next trials.
#include "calibrate/target.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/constants.hpp"
#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/closures.hpp"
#include "calibrate/onset.hpp"
#include "calibrate/table.hpp"

namespace drover::calibrate {

namespace {
constexpr int subdivisions = 5;  // enough to see a crossing and a fall back between two area fractions

bool is_onset(const TableTarget& target) { return target.row.empty(); }

/// A target in one table.
struct Value {
    double value = nan;
    double excess = nan, slope = nan;  ///< of an onset, see OnsetPlace
};

/// Those of the onset that share a value of the varied key are found together.
void add_onsets(const std::vector<TableTarget>& targets, const Table& table, std::vector<Value>& values) {
    for (std::size_t varied = 0; varied < table.varied.size(); ++varied) {
        std::vector<std::size_t> which;
        std::vector<double> rods;
        for (std::size_t k = 0; k < targets.size(); ++k)
            if (is_onset(targets[k]) && targets[k].varied == varied) {
                which.push_back(k);
                rods.push_back(table.rod_fractions.at(targets[k].rod));
            }
        if (which.empty()) continue;
        const std::vector<OnsetPlace> places = find_crossings(table, varied, rods, subdivisions);
        for (std::size_t i = 0; i < which.size(); ++i) {
            const OnsetPlace& place = places[i];
            const bool crosses = !std::isnan(place.bead_fraction);
            values[which[i]] = {.value = crosses           ? place.bead_fraction
                                         : place.above_all ? -infinite
                                                           : infinite,
                                .excess = place.excess,
                                .slope = place.slope};
        }
    }
}

/// The table with all that follows from its rows and is needed.
std::vector<Value> values_of(const std::vector<TableTarget>& targets, Table table) {
    std::vector<Value> values(targets.size());
    if (std::ranges::all_of(targets, is_onset)) add_contact_alignment(table);
    else add_derived_values(table);
    add_onsets(targets, table, values);
    for (std::size_t k = 0; k < targets.size(); ++k) {
        if (is_onset(targets[k])) continue;
        const TableTarget& target = targets[k];
        const TableRow& row = *find_row(table, target.row);
        const std::size_t index = entry_index(table, row, target.varied, target.bead, target.rod);
        const TableEntry& entry = row.entries[index];
        require(entry.origin != Origin::missing, {}, "{} at {}: {}", row.name, point_text(table, row.by_rods, index),
                entry.remark);
        values[k].value = entry.value;
    }
    return values;
}

/// The rows that the targets follow from.
std::vector<std::string> used_rows(const Table& table, const std::vector<TableTarget>& targets) {
    std::vector<std::string> names, used;
    for (const TableRow& row : table.rows) {
        names.push_back(row.name);
        if (row.entries.front().origin == Origin::set) used.push_back(row.name);
    }
    for (const TableTarget& target : targets)
        for (const std::string& row : inputs_of(target, names)) used.push_back(row);
    return used;
}

/// NaN for all if the table has no values.
std::vector<Value> values_or_none(const std::vector<TableTarget>& targets, const Table& table) {
    try {
        return values_of(targets, table);
    } catch (const Error&) {
        return std::vector<Value>(targets.size());
    }
}

/// Slopes of all targets by one entry, from steps of half its error; 0 where it has none.
std::vector<double> slopes_by(TableEntry& entry, const std::vector<TableTarget>& targets,
                              const std::vector<Value>& centre, const Table& table) {
    const double step = 0.5 * entry.error, held = entry.value;
    std::vector<double> slopes(targets.size(), 0.0);
    if (!(step > 0.0)) return slopes;
    entry.value = held + step;
    const std::vector<Value> above = values_or_none(targets, table);
    entry.value = held - step;
    const std::vector<Value> below = values_or_none(targets, table);
    entry.value = held;
    for (std::size_t k = 0; k < targets.size(); ++k) {
        const bool by_excess = !std::isfinite(centre[k].value);
        const auto of = [&](const Value& one) { return by_excess ? one.excess : one.value; };
        const double up = of(above[k]), middle = of(centre[k]), down = of(below[k]);
        if (std::isfinite(up) && std::isfinite(down)) slopes[k] = 0.5 * (up - down) / step;
        else if (std::isfinite(up)) slopes[k] = (up - middle) / step;
        else if (std::isfinite(down)) slopes[k] = (middle - down) / step;
    }
    return slopes;
}

/// The part of one source in the variances of all targets, to first order.
std::vector<double> variances_by(const Source& source, const std::vector<TableTarget>& targets,
                                 const std::vector<Value>& centre, const Table& measured, Table& few) {
    std::vector<std::vector<double>> apart(targets.size(), std::vector<double>(error_draws, 0.0));
    for (const EntryPlace& place : source) {
        const auto row = std::ranges::find(few.rows, place.row, &TableRow::name);
        const std::vector<double> slopes = slopes_by(row->entries[place.entry], targets, centre, few),
                                  drawn =
                                      deviations(measured, *find_row(measured, place.row), place.entry, error_draws);
        for (std::size_t k = 0; k < targets.size(); ++k)
            for (std::size_t r = 0; r < drawn.size() && slopes[k] != 0.0; ++r) apart[k][r] += slopes[k] * drawn[r];
    }
    return mapped(apart, [](const std::vector<double>& of) {
        return std::inner_product(of.begin(), of.end(), of.begin(), 0.0) / error_draws;
    });
}

/// The same of what the measurements of c differ by.
std::vector<double> variances_by_disagreement(const std::vector<TableTarget>& targets, const std::vector<Value>& centre,
                                              Table few) {
    std::vector<double> variances(targets.size(), 0.0);
    add_contact_alignment(few);
    for (TableEntry& entry : std::ranges::find(few.rows, name_of(contact), &TableRow::name)->entries) {
        const std::vector<double> slopes = slopes_by(entry, targets, centre, few);
        for (std::size_t k = 0; k < targets.size(); ++k) variances[k] += std::pow(slopes[k] * entry.error, 2);
    }
    return variances;
}

void set_error(const TableTarget& target, std::size_t k, const std::vector<std::vector<Value>>& redrawn,
               TargetResult& result) {
    std::vector<double> values{result.value}, slopes;
    for (const std::vector<Value>& one : redrawn) {
        if (!std::isnan(one[k].value)) values.push_back(one[k].value);
        if (std::isfinite(one[k].slope)) slopes.push_back(one[k].slope);
    }
    std::ranges::sort(values);
    std::ranges::sort(slopes);
    result.quantiles = {quantile(values, below_one_sigma), quantile(values, 0.5),
                        quantile(values, 1.0 - below_one_sigma)};
    const auto [low, median, high] = result.quantiles;
    const auto same = static_cast<double>(std::ranges::count(values, median));
    constexpr double nearly_all = 0.975;
    result.is_beyond = std::isinf(median) && same >= nearly_all * static_cast<double>(values.size());
    result.error = std::isfinite(low) && std::isfinite(high) ? 0.5 * (high - low) : infinite;
    result.allowed = target.error * (target.is_relative ? std::abs(median) : 1.0);
    if (slopes.empty()) return;
    result.slope_error = half_width(slopes) / quantile(slopes, 0.5);
}

/// The inputs of the row of a target.
std::vector<Input> closure_inputs(const TableTarget& target, std::vector<std::string> names) {
    if (is_onset(target)) return {drag, relaxation, weathercock, contact};
    if (target.row == name_of(contact)) return {contact};
    for (const Closure& closure : closures()) {
        if (closure.row.empty()) continue;
        if (closure.row == target.row)
            return scaled(closure, {rod_area, speed}, [](const ClosureNumbers&) { return 1.0; }).of;
        names.push_back(closure.row);
    }
    names.insert(names.end(), {"onset", name_of(contact)});
    fail_input({}, "a calibration has no number {}; {}expected onset, alignment or another row of its table",
               target.row, suggestion(target.row, names, "", "did you mean {}? "));
}

/// By how much the variances above 1 fall with one more trial, for a core second.
double gain(const TrialCosts& source, const std::vector<double>& sums) {
    double fall = 0.0;
    for (std::size_t k = 0; k < sums.size(); ++k)
        if (sums[k] > 1.0) fall += source.variances[k] * source.caution;
    return fall / (static_cast<double>(source.trials + 1) * source.seconds);
}
}  // namespace

std::vector<TargetResult> evaluate(const std::vector<TableTarget>& targets, const Table& measured,
                                   const std::vector<Source>& sources) {
    std::vector<std::string> rows = used_rows(measured, targets);
    Table few = slim(measured, rows);
    std::vector<TargetResult> results(targets.size());
    for (TargetResult& result : results) result.parts.assign(sources.size(), 0.0);
    std::vector<Value> centre;
    try {
        centre = values_of(targets, few);
    } catch (const Error& error) {
        for (std::size_t k = 0; k < targets.size(); ++k)
            results[k] = {.value = nan,
                          .error = infinite,
                          .allowed = targets[k].is_relative ? nan : targets[k].error,
                          .parts = std::move(results[k].parts),
                          .missing = error.what()};
        return results;
    }
    Table whole = measured;
    add_contact_alignment(whole);
    rows.emplace_back(name_of(contact));
    std::vector<std::vector<Value>> redrawn;
    for_redrawn_tables(whole, rows, error_draws,
                       [&](const Table& one) { redrawn.push_back(values_or_none(targets, one)); });
    const std::vector<double> by_disagreement = variances_by_disagreement(targets, centre, few);
    for (std::size_t s = 0; s < sources.size(); ++s) {
        const std::vector<double> variances = variances_by(sources[s], targets, centre, measured, few);
        for (std::size_t k = 0; k < targets.size(); ++k) results[k].parts[s] = variances[k];
    }
    for (std::size_t k = 0; k < targets.size(); ++k) {
        double sum = by_disagreement[k];
        for (const double part : results[k].parts) sum += part;
        if (sum > 0.0) {
            for (double& part : results[k].parts) part /= sum;
            results[k].disagreement = by_disagreement[k] / sum;
        }
        results[k].value = centre[k].value;
        set_error(targets[k], k, redrawn, results[k]);
    }
    return results;
}

std::vector<std::string> inputs_of(const TableTarget& target, const std::vector<std::string>& measured_rows) {
    const auto is_measured = [&](const std::string& row) {
        return std::ranges::find(measured_rows, row) != measured_rows.end();
    };
    if (is_measured(target.row)) return {target.row};
    std::vector<std::string> rows;
    for (const Input input : closure_inputs(target, measured_rows)) {
        const bool is_of_setup = input == bead_area || input == rod_area || input == bead_mass;
        if (input == contact) {
            if (is_measured("alignment_reference") || is_measured("contact_reference"))
                for (const std::string& row : contact_rows())
                    if (is_measured(row)) rows.push_back(row);
        } else if (const bool is_zero = input == stiffness || input == cubic;
                   !is_of_setup && (!is_zero || is_measured(name_of(input)))) {
            rows.push_back(name_of(input));
        }
    }
    for (const std::string& row : rows)
        require(is_measured(row), {},
                "{} needs {}, which no assay of the scene measures; add its assay to "
                "calibrate.assays",
                is_onset(target) ? "the onset" : target.row, row);
    return rows;
}

std::vector<std::size_t> allocate(std::vector<TrialCosts> sources, double seconds) {
    std::vector<std::size_t> added(sources.size(), 0);
    if (sources.empty()) return added;
    std::vector<double> sums(sources.front().variances.size(), 0.0);
    for (const TrialCosts& source : sources)
        for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += source.variances[k];
    while (seconds > 0.0) {
        std::size_t best = sources.size();
        double max_gain = 0.0;
        for (std::size_t s = 0; s < sources.size(); ++s)
            if (const double here = gain(sources[s], sums);
                here > max_gain && sources[s].trials < sources[s].max_trials)
                best = s, max_gain = here;
        if (best == sources.size()) break;
        TrialCosts& source = sources[best];
        const double ratio = static_cast<double>(source.trials) / static_cast<double>(source.trials + 1);
        for (std::size_t k = 0; k < sums.size(); ++k) {
            sums[k] -= source.variances[k] * (1.0 - ratio);
            source.variances[k] *= ratio;
        }
        ++source.trials;
        ++added[best];
        seconds -= source.seconds;
    }
    return added;
}

}  // namespace drover::calibrate
