// run/report/field_report.cpp: the results of a run of fields beside their linear theory.
#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "measure/fields.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "physics/program_functions.hpp"
#include "run/fields/field_prediction.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/scene_support.hpp"
#include "run/report/report.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// A structure factor that linear theory has: of two parts of fields, as model::part_names.
struct PredictedRow {
    std::string name;
    std::size_t one = 0, other = 0;
    std::string counted = {};  ///< of what number fluctuations are; "": of nothing
};

/// What an archive holds.
struct ArchivedFields {
    measure::FieldSetting setting;
    measure::Recorded recorded;
    BiasedRows biased;
    std::vector<PredictedRow> predicted;
};

/// The structure factors of the observables.
std::vector<PredictedRow> predicted_rows(const model::Model& model, const measure::FieldSetting& setting) {
    const std::vector<model::PlacedField> fields = model::placed_fields(model);
    std::vector<PredictedRow> rows;
    for (const measure::MeasuredField& field : setting.fields) {
        const std::string name = "structure_factor_" + field.short_name;
        const std::size_t first = fields[field.field].first;
        if (field.spin == 0) rows.push_back({name, first, first, field.counted});
        else {
            rows.push_back({name + "_along", first, first});
            rows.push_back({name + "_across", first + 1, first + 1});
        }
        for (const measure::MeasuredField& other : setting.fields)
            if (field.first < other.first && field.spin == 0 && other.spin == 0)
                rows.push_back({name + "_" + other.short_name, first, fields[other.field].first});
    }
    return rows;
}

std::vector<bool> shells_with_errors(const measure::FieldSetting& setting, double shortest) {
    const numerics::KeptGrid fine{setting.grid, setting.degree};
    const std::vector<int>& shells = setting.shells.of_mode;
    std::vector<std::int64_t> missing(setting.shells.q.size());
    for (const int shell : shells)
        if (shell >= 0) ++missing[static_cast<std::size_t>(shell)];
    for (const numerics::ModePair& mode :
         numerics::shared_modes(numerics::coarse_grid(setting.grid, setting.degree, false, shortest), fine))
        if (shells[mode.fine] >= 0) --missing[static_cast<std::size_t>(shells[mode.fine])];
    return mapped(missing, [](std::int64_t modes) { return modes == 0; });
}

/// The observables that the archive has: those of earlier versions have fewer.
ArchivedFields measured_in(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                           const Sampling& sampling) {
    const model::Equations& equations = what.equations;
    ArchivedFields result{.setting = measure::make_field_setting(equations, scene.grid, what.kept_degree)};
    measure::FieldSetting& setting = result.setting;
    const auto is_absent = [&](const auto& row) {
        return !archive.has(std::string(field_samples_group) + "/" + row.name);
    };
    setting.watches_error = false;
    const auto biased = measure::field_observables(setting);
    result.biased.has_all = std::ranges::none_of(biased, is_absent);
    for (const auto& row : biased)
        result.biased.rows.push_back({row.name, measure::size_of(row.axes), !row.is_of_grid,
                                      !row.axes.empty() && row.axes.back().values == setting.shells.q});
    result.biased.has_shell = shells_with_errors(setting, what.shortest);
    for (const measure::MeasuredField& field : setting.fields)
        if (!field.counted.empty()) result.biased.densities.push_back(field.counted);
    if (scene.output.powers) setting.terms = names_of_terms(scene, equations);
    setting.watches_error = true;
    auto rows = measure::field_observables(setting);
    std::erase_if(rows, is_absent);
    result.recorded =
        measure::field_recording(setting, read_series(archive, field_samples_group, rows, sampling.samples));
    result.predicted = predicted_rows(equations.model(), setting);
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
                                   : nan);
        for (auto& [result, values] :
             {std::pair{"variance", &variance}, std::pair{"deviation", &deviation}, std::pair{"exponent", &exponent}})
            report.predictions.push_back({what + "_number_" + result + family.ending, std::move(*values)});
    }
}

void predict(const model::Equations& equations, const ArchivedFields& measured, Report& report) {
    Threads threads(choose_threads(report.scene));
    const auto series = [&](const std::string& name) {
        const measure::RecordedSeries* row = measure::find_row(measured.recorded.series, name);
        return row == nullptr ? std::vector<double>() : row->values;
    };
    const auto pairs = mapped(measured.predicted, [](const PredictedRow& row) { return PartPair(row.one, row.other); });
    FieldPrediction predicted =
        predicted_fields(report.scene, equations, sampled_means(equations, series, report.summary.warm_up), pairs,
                         measured.setting.degree, threads);
    report.no_prediction = predicted.why_none.value_or("");
    report.about = predicted.about;
    report.about_flock = predicted.about_order;
    if (predicted.why_none) return;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const PredictedRow& row = measured.predicted[k];
        report.predictions.push_back(
            {row.name, numerics::shell_means(measured.setting.grid, measured.setting.shells, predicted.powers[k])});
        if (!row.counted.empty()) predict_boxes(row.counted, std::move(predicted.powers[k]), report);
    }
}
}  // namespace

Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory) {
    const model::Integrated what = compiled_of(scene);
    Sampling sampling = sampling_of(archive, scene, field_samples_group);
    // Exactly stationary: a start that was found in the samples would be a fluctuation, and bias the means.
    const bool is_linear = !what.equations.has_explicit_part();
    if (!sampling.warm_up && scene.initial.kind == model::StartKind::stationary && is_linear) sampling.warm_up = 0;
    ArchivedFields measured = measured_in(archive, scene, what, sampling);
    Report report = summary_report(scene, sampling, measured.recorded);
    report.setting = measured.setting;
    report.step_bias = step_biases(archive, scene, is_linear, std::move(measured.biased), report.summary);
    if (const std::string missing = physics::missing_function(scene.model); !missing.empty()) {
        report.warnings = {missing + ": no linear theory and no warnings here; the archive has both"};
    } else {
        if (theory == Theory::included) predict(what.equations, measured, report);
        report.warnings = field_warnings(archive, scene, what);
        std::ranges::move(step_bias_warnings(report.step_bias, scene, report.summary),
                          std::back_inserter(report.warnings));
    }
    io::rename_units(report.summary.rows, scene.units);
    for (measure::SummaryRow& row : report.summary.rows) io::rename_units(row.axes, scene.units);
    return report;
}

}  // namespace drover::run
