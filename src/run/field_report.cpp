// run/field_report.cpp: the results of a run of fields beside their linear theory.
#include <cmath>
#include <limits>

#include "drover/measure/fields.hpp"
#include "drover/measure/model_fields.hpp"
#include "drover/numerics/shells.hpp"
#include "drover/physics/energy.hpp"
#include "drover/physics/function_terms.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/report.hpp"
#include "drover/run/warnings.hpp"
#include "run/field_prediction.hpp"
#include "run/sample_recording.hpp"
#include "run/scene_equations.hpp"

namespace drover::run {

namespace {
/// A structure factor that linear theory has: of two parts of fields, as model::part_names.
struct PredictedRow {
    std::string name;
    std::size_t one = 0, other = 0;
    std::string counted = {};  ///< of what number fluctuations are; "": of nothing
};

/// What an archive holds.
struct Measured {
    measure::FieldSetting setting;
    measure::Recorded recorded;
    BiasedRows biased;
    std::vector<PredictedRow> predicted;
};

/// The first part of each field.
std::vector<std::size_t> first_parts(const model::Model& model) {
    std::vector<std::size_t> first{0};
    for (const model::Field& field : model.fields)
        first.push_back(first.back() + static_cast<std::size_t>(model::components(field)));
    return first;
}

void add_rows(const std::string& name, const model::Field& field, std::size_t first, const std::string& counted,
              std::vector<PredictedRow>& rows) {
    if (field.spin == 0) rows.push_back({name, first, first, counted});
    else {
        rows.push_back({name + "_along", first, first});
        rows.push_back({name + "_across", first + 1, first + 1});
    }
}

/// As observables of rods and beads are named.
std::vector<PredictedRow> rod_bead_rows(const model::Model& model) {
    constexpr std::array names{std::pair{"rho", "beads"}, std::pair{"sigma", "rods"}, std::pair{"v", "velocity"},
                               std::pair{"p", "order"}};
    const std::vector<std::size_t> first = first_parts(model);
    std::vector<PredictedRow> rows;
    std::vector<std::size_t> densities;
    for (std::size_t n = 0; n < model.fields.size(); ++n) {
        const model::Field& field = model.fields[n];
        for (const auto& [symbol, name] : names)
            if (field.symbol == symbol)
                add_rows(text("structure_factor_{}", name), field, first[n],
                         field.spin == 0 ? std::string(name, std::string_view(name).size() - 1) : "", rows);
        if (field.spin == 0) densities.push_back(first[n]);
    }
    if (densities.size() == 2) rows.push_back({"structure_factor_beads_rods", densities[0], densities[1]});
    return rows;
}

Measured measured_rods_and_beads(const files::ArchiveReader& archive, const io::Scene& scene,
                                 const model::Equations& solver, const Sampling& sampling) {
    const physics::Equations equations(scene.model);
    Measured result{.setting = measure::make_field_setting(scene.grid, physics::form(scene.model),
                                                           physics::kept_degree(equations, scene.dealiasing)),
                    .predicted = rod_bead_rows(solver.model())};
    result.setting.watches_error = false;
    result.biased = biased_rows(measure::field_observables(result.setting), {"rod", "bead"});
    if (scene.output.powers) {
        Threads one(1);
        result.setting.terms = physics::EnergyMeter(equations, scene.grid, scene.dealiasing, one).terms();
    }
    result.setting.watches_error = scene.time.max_error > 0.0;
    result.recorded = measure::field_recording(result.setting, read_series(archive, field_samples_group,
                                                                           measure::field_observables(result.setting),
                                                                           sampling.samples));
    return result;
}

Measured measured_model(const files::ArchiveReader& archive, const io::Scene& scene, const model::Equations& equations,
                        const Sampling& sampling) {
    // Archives of before November 2026 have no estimate.
    const bool watches = scene.time.max_error > 0.0 && archive.has(std::string(field_samples_group) + "/step_error");
    const std::vector<model::StateComponent> balanced = model::components_in_balance(equations);
    const bool with_balanced =
        !balanced.empty() && archive.has(std::string(field_samples_group) + "/mean_" + balanced.front().name);
    measure::ModelSetting setting =
        measure::make_model_setting(equations, scene.grid, io::kept_degree(scene, equations), false, with_balanced);
    std::vector<std::string> densities;
    for (const measure::MeasuredField& field : setting.fields)
        if (field.is_density) densities.push_back(field.name);
    Measured result{.biased = biased_rows(measure::model_observables(setting), std::move(densities))};
    setting.grid.watches_error = watches;
    result.recorded =
        measure::model_recording(setting, read_series(archive, field_samples_group, measure::model_observables(setting),
                                                      sampling.samples));
    result.setting = setting.grid;
    const model::Model& model = equations.model();
    const std::vector<std::size_t> first = first_parts(model);
    for (const measure::MeasuredField& field : setting.fields) {
        const std::size_t n = setting.components[static_cast<std::size_t>(field.first)].field;
        add_rows("structure_factor_" + field.name, model.fields[n], first[n], field.is_density ? field.name : "",
                 result.predicted);
        for (const measure::MeasuredField& other : setting.fields) {
            const std::size_t m = setting.components[static_cast<std::size_t>(other.first)].field;
            if (field.first < other.first && field.spin == 0 && other.spin == 0)
                result.predicted.push_back(
                    {text("structure_factor_{}_{}", field.name, other.name), first[n], first[m]});
        }
    }
    return result;
}

/// The predictions of <what>_number_* from the structure factor of each stored mode.
void predict_boxes(const std::string& what, std::vector<double> powers, Report& report) {
    const measure::FieldSetting& setting = report.setting;
    for (double& power : powers) power /= numerics::area(setting.grid);
    for (const measure::BoxFamily& family : measure::box_families()) {
        std::vector<double> variance, deviation, exponent, areas;
        for (const int side : setting.*family.sides) {
            const numerics::BoxCells box = numerics::box_cells(setting.grid, side, family.along_x, family.along_y);
            variance.push_back(numerics::box_variance(setting.grid, powers, box.x, box.y));
            deviation.push_back(std::sqrt(variance.back()));
            areas.push_back(static_cast<double>(box.x) * box.y);
        }
        // d log deviation/d log area between one box and the next; NaN at the last.
        for (std::size_t b = 0; b < variance.size(); ++b)
            exponent.push_back(b + 1 < variance.size()
                                   ? 0.5 * std::log(variance[b + 1] / variance[b]) / std::log(areas[b + 1] / areas[b])
                                   : std::numeric_limits<double>::quiet_NaN());
        for (auto& [result, values] :
             {std::pair{"variance", &variance}, std::pair{"deviation", &deviation}, std::pair{"exponent", &exponent}})
            report.predictions.push_back({what + "_number_" + result + family.ending, std::move(*values)});
    }
}

void predict(const model::Equations& equations, const Measured& measured, Report& report) {
    Threads threads(choose_threads(report.scene));
    const auto series = [&](const std::string& name) {
        const measure::RecordedSeries* row = measure::find_row(measured.recorded.series, name);
        return row == nullptr ? std::vector<double>() : row->values;
    };
    std::vector<PartPair> pairs;
    for (const PredictedRow& row : measured.predicted) pairs.emplace_back(row.one, row.other);
    FieldPrediction predicted =
        predicted_fields(report.scene, equations, sampled_means(equations, series, report.summary.warm_up), pairs,
                         measured.setting.degree, threads);
    report.no_prediction = predicted.why_none;
    report.about = predicted.about;
    report.about_flock = predicted.about_order;
    if (!predicted.why_none.empty()) return;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const PredictedRow& row = measured.predicted[k];
        report.predictions.push_back(
            {row.name, numerics::shell_means(measured.setting.grid, measured.setting.shells, predicted.powers[k])});
        if (!row.counted.empty()) predict_boxes(row.counted, std::move(predicted.powers[k]), report);
    }
}
}  // namespace

Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory) {
    const model::Equations equations = equations_of(scene);
    const Sampling sampling = sampling_of(archive, scene, field_samples_group);
    Measured measured = scene.kind == io::SceneKind::model
                            ? measured_model(archive, scene, equations, sampling)
                            : measured_rods_and_beads(archive, scene, equations, sampling);
    Report report = summary_report(scene, sampling, measured.recorded);
    report.setting = measured.setting;
    report.step_bias =
        step_biases(archive, scene, !equations.has_explicit_part(), std::move(measured.biased), report.summary);
    if (const std::string missing = physics::missing_function(scene.model); !missing.empty()) {
        report.warnings = {missing + ": no linear theory and no warnings here; the archive has both"};
        return report;
    }
    if (theory == Theory::included) predict(equations, measured, report);
    report.warnings = field_warnings(archive, scene);
    for (std::string& warning : step_bias_warnings(report.step_bias, scene, report.summary))
        report.warnings.push_back(std::move(warning));
    return report;
}

}  // namespace drover::run
