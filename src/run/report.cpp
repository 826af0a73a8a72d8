// run/report.cpp: results of an archive and their predictions by linear theory.
#include "drover/run/report.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

#include "base/constants.hpp"
#include "drover/physics/evaluation_cost.hpp"
#include "drover/physics/function_terms.hpp"
#include "drover/physics/predictions.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/warnings.hpp"
#include "run/sample_recording.hpp"

namespace drover::run {

namespace {
/// Number of samples on the schedule: the last one may be off it.
std::size_t regular_samples(const std::vector<double>& times, double spacing) {
    std::size_t count = 0;
    while (count < times.size() && std::abs(times[count] - spacing * static_cast<double>(count)) < 1e-6 * spacing)
        ++count;
    return count;
}

/// The mean order of each sample after the warm-up.
std::vector<Eigen::Vector2d> mean_orders(const std::vector<measure::RecordedSeries>& series, std::size_t warm_up) {
    const std::vector<double>&x = measure::find_row(series, "polar_order_mean_x")->values,
          &y = measure::find_row(series, "polar_order_mean_y")->values;
    std::vector<Eigen::Vector2d> result;
    for (std::size_t i = warm_up; i < x.size(); ++i) result.emplace_back(x[i], y[i]);
    return result;
}

void predict(const physics::Equations& equations, const std::vector<Eigen::Vector2d>& orders, Report& report) {
    Threads threads(choose_threads(report.scene));
    const physics::PredictedStructure predicted =
        physics::predicted_structure(equations, report.scene.grid, report.scene.dealiasing, orders, threads);
    report.no_prediction = predicted.no_prediction;
    report.about = predicted.about;
    report.about_flock = predicted.about_flock;
    const std::vector<physics::StructureFactor>& modes = predicted.modes;
    if (modes.empty()) return;
    const auto values_of = [&](double physics::StructureFactor::*part) {
        std::vector<double> values;
        for (const physics::StructureFactor& mode : modes) values.push_back(mode.*part);
        return values;
    };
    using Part = physics::StructureFactor;
    const physics::Form& form = report.setting.form;
    const bool beads = form.bead_density >= 0, rods = form.rod_density >= 0;
    const bool velocity = form.bead_velocity >= 0;  // a slaved velocity is not a field of the linear theory
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

void predict_boxes(const std::string& what, const std::vector<double>& structure_factor, Report& report) {
    const measure::FieldSetting& setting = report.setting;
    for (const measure::BoxFamily& family : measure::box_families()) {
        physics::PredictedBoxes boxes = physics::predicted_boxes(setting.grid, structure_factor, setting.*family.sides,
                                                                 family.along_x, family.along_y);
        for (auto& [result, values] : {std::pair{"variance", &boxes.variance}, std::pair{"deviation", &boxes.deviation},
                                       std::pair{"exponent", &boxes.exponent}})
            report.predictions.push_back({what + "_number_" + result + family.ending, std::move(*values)});
    }
}

Sampling sampling_of(const files::ArchiveReader& archive, const io::Scene& scene, const std::string& group) {
    const std::vector<double> times = archive.read(group + "/time").values;
    const bool two_alone = scene.output.sample_every == 0.0;
    Sampling sampling{.end = times.empty() ? 0.0 : times.back(),
                      .spacing = two_alone ? scene.time.end : scene.output.sample_every,
                      .samples = 0,
                      .warm_up = std::nullopt};
    sampling.samples = regular_samples(times, sampling.spacing);
    if (scene.analysis.warm_up >= 0.0 && scene.analysis.warm_up < scene.time.end)
        sampling.warm_up = static_cast<std::size_t>(std::ceil(scene.analysis.warm_up / sampling.spacing - 1e-9));
    return sampling;
}

Report summary_report(const io::Scene& scene, const Sampling& sampling, measure::Recorded& recorded) {
    recorded.spacing = sampling.spacing;
    recorded.warm_up = sampling.warm_up;
    Report report;
    report.scene = scene;
    report.time = sampling.end;
    report.summary = measure::summarise(recorded);
    return report;
}

namespace {
BiasedRows biased_rows_of(measure::FieldSetting setting) {
    setting.terms.reset();
    setting.watches_error = false;
    return biased_rows(measure::field_observables(setting), {"rod", "bead"});
}
}  // namespace

Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory) {
    const physics::Equations equations(scene.model);
    measure::FieldSetting setting = measure::make_field_setting(scene.grid, physics::form(scene.model),
                                                                physics::kept_degree(equations, scene.dealiasing));
    if (scene.output.powers) {
        Threads one(1);
        setting.terms = physics::EnergyMeter(equations, scene.grid, scene.dealiasing, one).terms();
    }
    setting.watches_error = scene.time.max_error > 0.0;
    const Sampling sampling = sampling_of(archive, scene, field_samples_group);
    measure::Recorded recorded =
        measure::field_recording(setting, read_series(archive, field_samples_group, measure::field_observables(setting),
                                                      sampling.samples));
    Report report = summary_report(scene, sampling, recorded);
    report.step_bias =
        step_biases(archive, scene, !equations.solver(physics::reference(scene.model.uniform)).has_explicit_part(),
                    biased_rows_of(setting), report.summary);
    report.setting = std::move(setting);
    if (const std::string missing = physics::missing_function(scene.model); !missing.empty()) {
        report.warnings = {missing + ": no linear theory and no warnings here; the archive has both"};
        return report;
    }
    if (theory == Theory::included) predict(equations, mean_orders(recorded.series, report.summary.warm_up), report);
    report.warnings = field_warnings(archive, scene);
    for (std::string& warning : step_bias_warnings(report.step_bias, scene, report.summary))
        report.warnings.push_back(std::move(warning));
    return report;
}

std::vector<files::Axis> file_axes(const std::vector<measure::Axis>& axes) {
    std::vector<files::Axis> result;
    for (const measure::Axis& axis : axes) result.push_back({axis.name, axis.unit, axis.meaning, axis.values});
    return result;
}

ScheduledRecording sample_recording(const io::Scene& scene, const char* group, const std::vector<measure::Axis>& axes,
                                    std::vector<files::Quantity> quantities,
                                    std::function<std::vector<std::vector<double>>()> measure) {
    const auto values = std::make_shared<std::vector<std::vector<double>>>();
    return {{.group = group,
             .axes = file_axes(axes),
             .quantities = std::move(quantities),
             .rows_per_chunk = samples_per_chunk(scene)},
            io::whole_steps(scene, "output.sample_every", scene.output.sample_every),
            [measure = std::move(measure), values] { return lend(*values, measure()); }};
}

const Prediction* find_prediction(const Report& report, const std::string& name) {
    for (const Prediction& prediction : report.predictions)
        if (prediction.name == name) return &prediction;
    return nullptr;
}

files::ResultTable result_table(const Report& report) {
    files::ResultTable table{.group = "/summary",
                             .axes = file_axes(measure::axes_of(report.summary.rows)),
                             .quantities = {},
                             .values = {},
                             .warnings = report.warnings};
    const std::string time_unit = io::renamed("s", report.scene.units);
    for (const measure::SummaryRow& row : report.summary.rows) {
        std::vector<double> means, errors, times;
        for (const measure::Estimate& estimate : row.estimates) {
            means.push_back(estimate.mean);
            errors.push_back(estimate.error.value_or(nan));
            times.push_back(estimate.autocorrelation_time);
        }
        const auto add = [&](const std::string& ending, const std::string& unit, const std::string& meaning,
                             std::vector<double> values) {
            table.quantities.push_back({row.name + ending, unit, meaning, measure::names_of(row.axes)});
            table.values.push_back(std::move(values));
        };
        add("", row.unit, row.formula, std::move(means));
        add("_error", row.unit, "standard error of " + row.name + "; NaN where there is no error estimate",
            std::move(errors));
        if (const auto biases = report.step_bias.of.find(row.name); biases != report.step_bias.of.end()) {
            std::vector<double> values, uncertainties;
            for (const StepBiasEstimate& bias : biases->second) {
                values.push_back(bias.bias);
                uncertainties.push_back(bias.error);
            }
            add("_step_bias", row.unit,
                row.name + " less its value for a step of zero length; NaN where accuracy.effort does not resolve it",
                std::move(values));
            add("_step_bias_error", row.unit, "uncertainty of that bias", std::move(uncertainties));
        }
        add("_autocorrelation_time", time_unit, "integrated autocorrelation time of " + row.name, std::move(times));
        if (const Prediction* prediction = find_prediction(report, row.name))
            add("_linear", row.unit, "linear theory of " + row.name + " on the same grid", prediction->values);
    }
    table.quantities.push_back({"warm_up", time_unit, "time left out of means at the start", {}});
    table.values.push_back(
        {static_cast<double>(report.summary.warm_up) *
         (report.scene.output.sample_every == 0.0 ? report.scene.time.end : report.scene.output.sample_every)});
    return table;
}

}  // namespace drover::run
