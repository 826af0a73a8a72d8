// jobs/calibration/calibration_layout.cpp: assays at points, from the section [calibrate]; tables from trials, and as
// TOML.
#include "jobs/calibration/calibration_layout.hpp"

#include <algorithm>
#include <cmath>

#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/catalogue.hpp"
#include "calibrate/setup_rows.hpp"
#include "calibrate/table.hpp"
#include "io/scene.hpp"
#include "run/number_lists.hpp"

namespace drover::jobs {

namespace {
using calibrate::missing;
using calibrate::Origin;
using calibrate::TableEntry;

constexpr const char *calibrate_key = "calibrate.vary", *calibrate_example = "\"kick.strength = 0.01, 0.02\"";

void read_varied(const io::Scene& scene, calibrate::Table& axes) {
    const std::string& written = scene.calibration.vary;
    if (written.empty()) return;
    const SourceLocation where = io::locate(scene, calibrate_key);
    const auto [key, values] = run::read_assignment(written, calibrate_key, calibrate_example, where);
    for (const char* own :
         {"run.", "output.", "sweep.", "analysis.", "calibrate.", "packing.", "forces.", "time.", "beads.area_fraction",
          "beads.count", "rods.area_fraction", "rods.count", "cell.shape", "gravity.x", "gravity.y"})
        require(!key.starts_with(own), where,
                "calibrate.vary names {}; expected a key of the bodies, the plates or the contacts", key);
    axes.varied_key = key;
    axes.varied = mapped(run::split(values, ','), [&](const std::string& word) {
        return run::read_number(word, written, calibrate_key, calibrate_example, where);
    });
    require(!axes.varied.empty(), where, "calibrate.vary = \"{}\" has no values; expected at least one", written);
    for (std::size_t i = 1; i < axes.varied.size(); ++i)
        require(axes.varied[i] > axes.varied[i - 1], where, "calibrate.vary has {} after {}; expected ascending values",
                axes.varied[i], axes.varied[i - 1]);
}

/// Assays hold and release beds whose mean velocity is zero without their forces.
void require_level_plates(const io::Scene& scene) {
    const dem::Gravity& gravity = scene.particles.gravity;
    for (const auto& [key, value] : {std::pair{"gravity.x", gravity.x}, std::pair{"gravity.y", gravity.y}})
        require(value == 0.0, io::locate(scene, key),
                "{} = {} mm/s^2: tilted plates drive the bed, which the assays of drover calibrate would take for what "
                "they measure; expected 0",
                key, value);
}

std::string section_of(const std::string& assay) { return "calibrate." + assay; }

/// The plan of one assay, as scene text.
std::string plan_of(const io::Scene& scene, const std::string& assay) {
    const std::string section = section_of(assay), keys = section + ".";
    return "\n" +
           io::chosen_text(scene, [&](const std::string& one) { return one == section || one.starts_with(keys); });
}

/// What every trial depends on, whatever its assay and point: the scene with all other keys at their defaults, and
/// without the plans of the assays.  A new assay, or another plan of one, leaves the trials of all others valid.
std::string manifest_of(io::Scene scene) {
    const int single_rods = scene.calibration.single_rods;
    scene.calibration = {};
    scene.calibration.single_rods = single_rods;
    scene.output = {};
    scene.analysis = {};
    scene.sweep = {};
    scene.time.end = io::TimeControl{}.end;
    scene.run.threads = 0;
    scene.particles.packing = {};
    scene.particles.forces = {};
    scene.particles.beads.count = scene.particles.rods.count = 0;
    scene.particles.beads.area_fraction = scene.particles.rods.area_fraction = 0.0;
    std::vector<std::string> plans;
    calibrate::for_plans(scene.plans, [&](const std::string& assay, const char*, const auto&) {
        plans.push_back(section_of(assay));
    });
    return io::chosen_text(scene, [&](const std::string& one) { return std::ranges::find(plans, one) == plans.end(); });
}

/// The setup of one point.  Values are checked here, before anything runs.
dem::Setup setup_at(const io::Scene& scene, const CalibrationLayout& layout, const CalibrationUnit& unit) {
    const calibrate::Table& axes = layout.axes;
    io::Scene alone = scene;  // assays place bodies and act on them themselves
    alone.particles.packing = {};
    alone.particles.forces = {};
    std::vector<std::string> overrides{"beads.count=0", text("beads.area_fraction={}", axes.bead_fractions[unit.bead])};
    const auto rods = [&](const std::string& count, const std::string& fraction) {
        overrides.push_back("rods.count=" + count);
        overrides.push_back("rods.area_fraction=" + fraction);
    };
    switch (layout.assays[unit.assay].population) {
        case calibrate::Population::beads: rods("0", "0"); break;
        case calibrate::Population::single_rods: rods(text("{}", scene.calibration.single_rods), "0"); break;
        case calibrate::Population::all: rods("0", text("{}", axes.rod_fractions[unit.rod])); break;
    }
    if (!axes.varied_key.empty()) overrides.push_back(text("{}={}", axes.varied_key, axes.varied[unit.varied]));
    return io::changed(alone, overrides).particles;
}

void add_unit(const io::Scene& scene, CalibrationUnit unit, CalibrationLayout& layout) {
    const calibrate::Table& axes = layout.axes;
    const calibrate::Assay& assay = layout.assays[unit.assay];
    std::string point = text("bead-{}", axes.bead_fractions[unit.bead]);
    if (assay.population == calibrate::Population::all) point += text("-rod-{}", axes.rod_fractions[unit.rod]);
    if (!axes.varied_key.empty()) point += text("-{}-{}", axes.varied_key, axes.varied[unit.varied]);
    unit.name = assay.name + "-" + point;
    const dem::Setup setup = setup_at(scene, layout, unit);
    if (assay.check) assay.check(setup, [&](const std::string& key) { return io::locate(scene, key); });
    unit.conditions = {.setup = setup,
                       .seed = calibrate::trial_seed(static_cast<std::uint64_t>(scene.run.seed), point, 0)};
    layout.units.push_back(std::move(unit));
}

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

CalibrationLayout plan_calibration(const io::Scene& scene) {
    io::require_kind(scene, io::SceneKind::particles, "calibrate");
    const io::CalibrationPlan& plan = scene.calibration;
    require(dem::is_periodic(scene.particles.cell), io::locate(scene, "cell.shape"),
            "cell.shape = \"{}\"; expected \"periodic\" for drover calibrate", scene.particles.cell.shape);
    require_level_plates(scene);
    require(!plan.bead_area_fractions.empty(), io::locate(scene, "calibrate.bead_area_fractions"),
            "nothing to calibrate; expected calibrate.bead_area_fractions, such as [0.2, 0.4, 0.6]");
    CalibrationLayout layout;
    layout.goal = {.relative_error = plan.relative_error,
                   .round = static_cast<std::size_t>(plan.round),
                   .max_trials = static_cast<std::size_t>(plan.max_trials)};
    layout.manifest = manifest_of(scene);
    io::Scene standard;
    standard.kind = io::SceneKind::particles;
    layout.defaults = io::resolved_text(standard);
    for (calibrate::Assay& assay : calibrate::make_assays(scene.plans))
        if (plan.assays.empty() || std::ranges::find(plan.assays, assay.name) != plan.assays.end())
            layout.assays.push_back(std::move(assay));
    layout.plans = mapped(layout.assays, [&](const calibrate::Assay& assay) { return plan_of(scene, assay.name); });
    layout.axes.bead_fractions = plan.bead_area_fractions;
    layout.axes.rod_fractions = plan.rod_area_fractions;
    read_varied(scene, layout.axes);
    constexpr double max_points = 10000.0;
    const double points = static_cast<double>(layout.axes.varied.size() * plan.bead_area_fractions.size()) *
                          static_cast<double>(std::max<std::size_t>(1, plan.rod_area_fractions.size()));
    require(points <= max_points, io::locate(scene, "calibrate.bead_area_fractions"),
            "a calibration of {:.3g} points; expected at most {:.0e}: choose fewer values", points, max_points);
    for (std::size_t varied = 0; varied < layout.axes.varied.size(); ++varied)
        for (std::size_t bead = 0; bead < plan.bead_area_fractions.size(); ++bead)
            for (std::size_t a = 0; a < layout.assays.size(); ++a) {
                const bool by_rods = layout.assays[a].population == calibrate::Population::all;
                require(!by_rods || !plan.rod_area_fractions.empty(), io::locate(scene, "calibrate.rod_area_fractions"),
                        "calibrate.rod_area_fractions is empty, but {} depends on it; set it, such as [0.05, 0.1], or "
                        "select other calibrate.assays",
                        layout.assays[a].name);
                for (std::size_t rod = 0; rod < (by_rods ? plan.rod_area_fractions.size() : 1); ++rod)
                    add_unit(scene,
                             {.name = {}, .assay = a, .varied = varied, .bead = bead, .rod = rod, .conditions = {}},
                             layout);
            }
    return layout;
}

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
