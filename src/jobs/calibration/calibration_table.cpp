// jobs/calibration/calibration_table.cpp: tables from trials, and as TOML.
#include <cmath>

#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/redraw.hpp"
#include "calibrate/setup_rows.hpp"
#include "jobs/calibration/calibration.hpp"

namespace drover::jobs {

namespace {
using calibrate::missing;
using calibrate::Origin;
using calibrate::TableEntry;

std::string joined_remarks(std::vector<std::string> parts) {
    std::erase(parts, "");
    return joined(parts, "; ");
}

/// The result of a trial set, or its result so far.
std::optional<calibrate::Measurement> result_of(const calibrate::TrialSet& trial_set) {
    return trial_set.ended() ? trial_set.measurement() : trial_set.so_far();
}

/// Of the resamples of a result.  They are of the same numbers for all units with equally many trials, but those of one
/// unit alone belong together: each unit has an order of its own.
std::vector<double> ranks_in(const std::vector<std::vector<double>>& resamples, std::size_t q,
                             const std::string& unit) {
    const std::vector<double> places = random_ranks(number_of_name(unit), 0, resamples.size());
    double sum = 0.0, count = 0.0;
    for (const std::vector<double>& one : resamples)
        if (std::isfinite(one[q])) sum += one[q], count += 1.0;
    std::vector<double> values;
    for (const double place : places) {
        const double value = resamples[static_cast<std::size_t>(place)][q];
        values.push_back(std::isfinite(value) ? value : sum / count);
    }
    return ranks_of(values);
}

TableEntry entry_of(const CalibrationLayout& layout, const calibrate::TrialSet& trial_set,
                    const std::optional<calibrate::Measurement>& measured, std::size_t q) {
    const int tried = static_cast<int>(trial_set.count());
    if (trial_set.failure_reason()) return missing(*trial_set.failure_reason(), tried);
    const std::string unfinished = trial_set.ended()        ? ""
                                   : trial_set.count() == 0 ? "no trial was made"
                                                            : text("not finished: {} of at least {} trials",
                                                                   trial_set.count(), trial_set.needed());
    if (!measured) return missing(unfinished, tried);
    const calibrate::Measurement& found = *measured;
    const measure::Estimate& estimate = found.estimates[q];
    const calibrate::Quantity& quantity = trial_set.assay().quantities[q];
    const int trials = static_cast<int>(found.trials);
    if (!estimate.error || !std::isfinite(estimate.mean))
        return missing(estimate.why_no_error.empty() ? "no value" : estimate.why_no_error, trials);
    TableEntry entry{.value = estimate.mean, .error = *estimate.error, .trials = trials, .origin = Origin::measured};
    if (!quantity.wanted) return entry;
    std::string unmet_target = unfinished;
    if (!unfinished.empty()) entry.origin = Origin::measured_short;
    else if (entry.error > layout.goal.relative_error * std::abs(entry.value)) {
        entry.origin = Origin::measured_short;
        unmet_target = !found.reached && found.unmet == q
                           ? found.unmet_target
                           : text("has an error of {:.3g} %; the target is {:.3g} %",
                                  100.0 * entry.error / std::abs(entry.value), 100.0 * layout.goal.relative_error);
    }
    const std::string failed =
        trial_set.failed() > 0 ? text("{} trials failed, the first: {}", trial_set.failed(), *trial_set.first_failure())
                               : "";
    entry.remark = joined_remarks({unmet_target, found.diagnosis, failed});
    return entry;
}

/// One number of each entry, in nested lists by the axes.
template <class Write>
std::string nested(const calibrate::Table& table, const calibrate::TableRow& row, Write write) {
    const std::size_t rods = row.by_rods ? table.rod_fractions.size() : 1;
    std::vector<std::string> all;
    std::size_t i = 0;
    for (std::size_t v = 0; v < table.varied.size(); ++v) {
        std::vector<std::string> by_bead;
        for (std::size_t b = 0; b < table.bead_fractions.size(); ++b) {
            std::vector<std::string> by_rod;
            for (std::size_t r = 0; r < rods; ++r) by_rod.push_back(write(row.entries[i++]));
            by_bead.push_back(row.by_rods ? "[" + joined(by_rod) + "]" : by_rod.front());
        }
        all.push_back("[" + joined(by_bead) + "]");
    }
    return table.varied_key.empty() ? all.front() : "[" + joined(all) + "]";
}
}  // namespace

void add_setup_rows(const CalibrationLayout& layout, calibrate::Table& table) {
    std::vector<std::vector<calibrate::SetupRow>> rows;
    for (const CalibrationUnit& unit : layout.units) rows.push_back(calibrate::setup_rows(unit.conditions.setup));
    for (std::size_t k = 0; !rows.empty() && k < rows.front().size(); ++k) {
        const calibrate::SetupRow& row = rows.front()[k];
        if (row.by_rods && table.rod_fractions.empty()) continue;
        calibrate::TableRow added{.name = row.name, .unit = row.unit, .formula = row.formula, .by_rods = row.by_rods};
        const TableEntry no_entry = missing("no assay was run at this point");
        added.entries.assign(calibrate::count_of(table, row.by_rods), no_entry);
        for (std::size_t u = 0; u < layout.units.size(); ++u) {
            const CalibrationUnit& unit = layout.units[u];
            const calibrate::Population population = layout.assays[unit.assay].population;
            if (row.by_rods && population != calibrate::Population::all) continue;
            if (row.of_rods && population == calibrate::Population::beads) continue;
            TableEntry& entry = added.entries[calibrate::entry_index(table, added, unit.varied, unit.bead, unit.rod)];
            if (entry.origin != Origin::set)
                entry = {.value = rows[u][k].number, .origin = Origin::set, .remark = rows[u][k].remark};
        }
        if (added.entries.front().origin == Origin::set) table.rows.push_back(std::move(added));
    }
}

void add_measured_rows(const CalibrationLayout& layout, const std::vector<calibrate::TrialSet>& trial_sets,
                       calibrate::Table& table) {
    const auto found = mapped(trial_sets, result_of);  // once for all quantities of a unit
    for (std::size_t a = 0; a < layout.assays.size(); ++a) {
        const calibrate::Assay& assay = layout.assays[a];
        const bool by_rods = assay.population == calibrate::Population::all;
        for (std::size_t q = 0; q < assay.quantities.size(); ++q) {
            const calibrate::Quantity& quantity = assay.quantities[q];
            calibrate::TableRow row{.name = quantity.name,
                                    .unit = quantity.unit,
                                    .formula = quantity.formula,
                                    .by_rods = by_rods};
            row.entries.resize(calibrate::count_of(table, by_rods));
            for (std::size_t u = 0; u < layout.units.size(); ++u) {
                const CalibrationUnit& unit = layout.units[u];
                if (unit.assay != a) continue;
                TableEntry& entry = row.entries[calibrate::entry_index(table, row, unit.varied, unit.bead, unit.rod)];
                entry = entry_of(layout, trial_sets[u], found[u], q);
                if (entry.error > 0.0 && calibrate::is_input(row.name))
                    entry.ranks = ranks_in(found[u]->resamples, q, unit.name);
            }
            table.rows.push_back(std::move(row));
        }
    }
}

calibrate::Table table_of(const CalibrationLayout& layout, const std::vector<calibrate::TrialSet>& trial_sets) {
    calibrate::Table table = layout.axes;
    add_measured_rows(layout, trial_sets, table);
    add_setup_rows(layout, table);
    calibrate::add_derived(table);
    return table;
}

std::string calibration_toml(const calibrate::Table& table, const std::string& heading) {
    std::string out =
        "# Coefficients over area fractions.  Lists are nested by the varied key, if any, then by beads, then by "
        "rods.\n" +
        heading;
    if (!table.varied_key.empty())
        out += "varied = " + toml_text(table.varied_key) + "\nvaried_values = " + toml_text(table.varied) + "\n";
    out += "bead_area_fraction = " + toml_text(table.bead_fractions) +
           "\nrod_area_fraction = " + toml_text(table.rod_fractions) + "\n";
    const auto number = [](double value) { return toml_text(Value(value)); };
    for (const calibrate::TableRow& row : table.rows) {
        out += text("\n[\"{}\"]\nunit = {}\nformula = {}\n", row.name, toml_text(row.unit), toml_text(row.formula));
        out += "value = " + nested(table, row, [&](const TableEntry& k) { return number(k.value); });
        out += "\nerror = " + nested(table, row, [&](const TableEntry& k) { return number(k.error); });
        out += "\ntrials = " + nested(table, row, [&](const TableEntry& k) { return text("{}", k.trials); });
        out += "\norigin = " +
               nested(table, row, [&](const TableEntry& k) { return toml_text(std::string(name_of(k.origin))); });
        std::vector<std::string> remarks;
        for (std::size_t i = 0; i < row.entries.size(); ++i)
            if (!row.entries[i].remark.empty())
                remarks.push_back(calibrate::point_text(table, row.by_rods, i) + ": " + row.entries[i].remark);
        out += remarks.empty() ? "\n" : "\nremarks = " + toml_text(remarks) + "\n";
    }
    return out;
}

}  // namespace drover::jobs
