// run/model_report.cpp: the results of a run of a declared model, and its warnings.
#include <algorithm>
#include <cmath>

#include "drover/measure/model_fields.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/model_simulation.hpp"
#include "drover/run/warnings.hpp"
#include "run/sample_recording.hpp"

namespace drover::run {

namespace {
/// Of the second half of the run, the largest part of a field's variance in its shortest waves.
double worst_tail(const measure::RecordedSeries& tails, const measure::RecordedSeries& variances) {
    double worst = 0.0;
    const std::vector<double>&tail = tails.values, &variance = variances.values;
    const double most = variance.empty() ? 0.0 : *std::max_element(variance.begin(), variance.end());
    for (std::size_t i = tail.size() / 2; i < tail.size(); ++i)
        if (variance[i] > 1e-12 * most) worst = std::max(worst, tail[i]);  // not of rounding
    return worst;
}

/// White noise feeds all waves alike, so that its tail says nothing about the products.
bool has_white_noise(const model::Model& model) {
    return std::any_of(model.fields.begin(), model.fields.end(),
                       [](const model::Field& field) { return field.noise > 0.0; });
}

void warn_of_tails(const io::Scene& scene, const model::Equations& equations, const measure::ModelSetting& setting,
                   const std::vector<measure::RecordedSeries>& series, std::vector<std::string>& warnings) {
    if (equations.degree() == 1 || has_white_noise(equations.model())) return;
    for (const measure::MeasuredField& field : setting.fields) {
        const auto *tails = measure::find_row(series, "spectral_tail_" + field.name),
                   *variances = measure::find_row(series, "variance_" + field.name);
        if (tails == nullptr || variances == nullptr) continue;
        const double tail = worst_tail(*tails, *variances);
        if (tail > max_spectral_tail)
            warnings.push_back(
                text("the grid does not resolve {}: {:.2g} of its variance is in the shortest waves "
                     "(spectral_tail_{}); expected less than {}: choose grid.nx = {}{}",
                     field.name, tail, field.name, max_spectral_tail, 2 * scene.grid.nx,
                     scene.grid.ny > 1 ? text(" and grid.ny = {}", 2 * scene.grid.ny) : ""));
    }
}
}  // namespace

std::vector<std::string> model_warnings(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    std::vector<std::string> warnings =
        model::start_warnings(io::start_of(scene), equations, scene.grid, io::kept_degree(scene, equations));
    if (!equations.has_finite_degree())
        warnings.emplace_back(
            "some functions of the equations are no polynomials: their aliases are not removed exactly; compare with a "
            "run on twice the points");
    if (scene.initial.kind != "uniform" || equations.has_noise()) return warnings;
    if (equations.uniform_rates(equations.reference()).cwiseAbs().maxCoeff() == 0.0)
        warnings.emplace_back(
            "the start is uniform, stationary and without noise: nothing will change; choose another initial.kind, "
            "such as \"random\"");
    return warnings;
}

Report make_model_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory) {
    const model::Equations equations(io::model_of(scene.declared));
    const measure::ModelSetting setting =
        measure::make_model_setting(equations, scene.grid, io::kept_degree(scene, equations));
    const Sampling sampling = sampling_of(archive, scene, field_samples_group);
    measure::Recorded recorded =
        measure::model_recording(setting, read_series(archive, field_samples_group, measure::model_observables(setting),
                                                      sampling.samples));
    Report report = summary_report(scene, sampling, recorded);
    report.setting = setting.grid;
    report.warnings = model_warnings(scene);
    warn_of_tails(scene, equations, setting, recorded.series, report.warnings);
    return report;
}

}  // namespace drover::run
