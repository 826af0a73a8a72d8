// run/report.cpp: from an archive to results and their predictions.
#include "drover/run/report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "drover/run/field_simulation.hpp"

namespace drover::run {

namespace {
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Samples that stand on the schedule: the last one may not.
std::size_t regular_samples(const std::vector<double>& times, double spacing) {
    std::size_t count = 0;
    while (count < times.size() && std::abs(times[count] - spacing * static_cast<double>(count)) < 1e-6 * spacing)
        ++count;
    return count;
}

std::vector<double> box_variances(const measure::Setting& setting, std::span<const double> structure_factor) {
    std::vector<double> power(structure_factor.begin(), structure_factor.end());
    for (double& value : power) value /= numerics::area(setting.grid);
    std::vector<double> result;
    for (const int cells : setting.boxes) result.push_back(numerics::box_variance(setting.grid, power, cells, cells));
    return result;
}

/// Number fluctuations in boxes that follow from a structure factor.
void predict_boxes(const std::string& what, std::span<const double> structure_factor, Report& report) {
    const std::vector<double> variances = box_variances(report.setting, structure_factor);
    Prediction deviation{what + "_number_deviation", {}}, exponent{what + "_number_exponent", {}};
    const std::vector<int>& boxes = report.setting.boxes;
    for (std::size_t b = 0; b < variances.size(); ++b) {
        deviation.values.push_back(std::sqrt(variances[b]));
        exponent.values.push_back(b + 1 < variances.size()
                                      ? 0.5 * std::log(variances[b + 1] / variances[b]) /
                                            (2.0 * std::log(static_cast<double>(boxes[b + 1]) / boxes[b]))
                                      : not_a_number);
    }
    report.predictions.push_back({what + "_number_variance", variances});
    report.predictions.push_back(std::move(deviation));
    report.predictions.push_back(std::move(exponent));
}

void predict(Report& report) {
    const numerics::System system =
        physics::linear_system(report.scene.model, report.scene.grid, report.scene.dealiasing);
    if (!system.noise) {
        report.no_prediction = "without noise the stationary state of the linear theory is uniform";
        return;
    }
    const physics::FastestGrowth growth = physics::fastest_growth(system);
    std::vector<physics::StructureFactor> modes;
    try {
        modes = physics::structure_factors(system, report.setting.form);
    } catch (const Error& error) {
        report.no_prediction = text("the linear theory has {} (fastest rate {:.3g} /s at |q| = {:.3g} /mm)",
                                    error.what(), growth.rate, growth.q);
        return;
    }
    const auto values_of = [&](double physics::StructureFactor::*part) {
        std::vector<double> values;
        for (const physics::StructureFactor& mode : modes) values.push_back(mode.*part);
        return values;
    };
    using Part = physics::StructureFactor;
    const physics::Form& form = report.setting.form;
    const bool beads = form.bead_density >= 0, rods = form.rod_density >= 0;
    const bool velocity = form.bead_velocity >= 0;  // a slaved velocity is no field of the linear theory
    for (const auto& [name, part, has] :
         {std::tuple{"rods", &Part::rods, rods}, std::tuple{"beads", &Part::beads, beads},
          std::tuple{"beads_rods", &Part::beads_rods, beads && rods},
          std::tuple{"order_along", &Part::order_along, true}, std::tuple{"order_across", &Part::order_across, true},
          std::tuple{"velocity_along", &Part::velocity_along, velocity},
          std::tuple{"velocity_across", &Part::velocity_across, velocity}})
        if (has)
            report.predictions.push_back(
                {text("structure_factor_{}", name),
                 numerics::shell_means(report.setting.grid, report.setting.shells, values_of(part))});
    if (rods) predict_boxes("rod", values_of(&Part::rods), report);
    if (beads) predict_boxes("bead", values_of(&Part::beads), report);
}
}  // namespace

Report make_report(const io::ArchiveReader& archive) {
    Report report{.scene = io::parse_scene(archive.text_attribute("scene"), archive.text_attribute("scene_file")),
                  .setting = {},
                  .summary = {},
                  .predictions = {},
                  .no_prediction = "",
                  .time = 0.0};
    const io::Scene& scene = report.scene;
    const physics::Form form = physics::form(scene.model);
    const physics::Equations equations(scene.model);
    const int degree = physics::kept_degree(equations, scene.dealiasing);
    std::vector<std::string> terms;
    if (scene.output.powers) {
        Threads one(1);
        terms = physics::EnergyMeter(equations, scene.grid, scene.dealiasing, one).terms();
    }
    report.setting = measure::make_setting(scene.grid, form, degree, terms);
    const std::vector<measure::Observable> observables = measure::observables(form, scene.output.powers);
    const std::vector<double> times = archive.read("/observables/time").values;
    report.time = times.empty() ? 0.0 : times.back();
    const bool two_alone = scene.output.sample_every == 0.0;
    const double spacing = two_alone ? scene.time.end : scene.output.sample_every;
    const std::size_t samples = regular_samples(times, spacing);
    std::vector<std::vector<double>> series;
    for (const measure::Observable& observable : observables) {
        series.push_back(archive.read("/observables/" + observable.name).values);
        series.back().resize(samples * measure::size_of(observable, report.setting));
    }
    measure::Recorded recorded{.setting = report.setting,
                               .observables = observables,
                               .series = series,
                               .spacing = spacing};
    if (scene.analysis.warm_up >= 0.0)
        recorded.warm_up = static_cast<std::size_t>(std::ceil(scene.analysis.warm_up / spacing - 1e-9));
    // What is conserved, from the run itself: a start from a file may have another mean than the scene's uniform state.
    for (std::size_t o = 0; o < observables.size(); ++o)
        for (const auto& [name, total] :
             {std::pair{"rods_total", &recorded.rods}, std::pair{"beads_total", &recorded.beads}})
            if (observables[o].name == name && !series[o].empty()) *total = series[o].front();
    report.summary = measure::summarise(recorded);
    predict(report);
    return report;
}

const Prediction* find_prediction(const Report& report, const std::string& name) {
    for (const Prediction& prediction : report.predictions)
        if (prediction.name == name) return &prediction;
    return nullptr;
}

io::ResultTable result_table(const Report& report) {
    io::ResultTable table{.group = "/summary", .axes = observable_axes(report.setting), .quantities = {}, .values = {}};
    for (const measure::SummaryRow& row : report.summary.rows) {
        const std::vector<std::string> axes = axis_names(row.axes);
        std::vector<double> means, errors, times;
        for (const measure::Estimate& estimate : row.estimates) {
            means.push_back(estimate.mean);
            errors.push_back(estimate.error.value_or(not_a_number));
            times.push_back(estimate.autocorrelation_time);
        }
        const auto add = [&](const std::string& ending, const std::string& unit, const std::string& meaning,
                             std::vector<double> values) {
            table.quantities.push_back({row.name + ending, unit, meaning, axes});
            table.values.push_back(std::move(values));
        };
        add("", row.unit, row.formula, std::move(means));
        add("_error", row.unit, "standard error of " + row.name + "; not-a-number where it was refused",
            std::move(errors));
        add("_autocorrelation_time", "s", "integrated autocorrelation time of " + row.name, std::move(times));
        if (const Prediction* prediction = find_prediction(report, row.name))
            add("_linear", row.unit, "linear theory of " + row.name + " on the same grid", prediction->values);
    }
    table.quantities.push_back({"warm_up", "s", "time left out of means at the start", {}});
    table.values.push_back(
        {static_cast<double>(report.summary.warm_up) *
         (report.scene.output.sample_every == 0.0 ? report.scene.time.end : report.scene.output.sample_every)});
    return table;
}

}  // namespace drover::run
