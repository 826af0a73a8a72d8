// run/report/report.cpp: the samples of an archive, their summary, and its table.
#include "run/report/report.hpp"

#include <cmath>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "drover/base/text.hpp"

namespace drover::run {

std::size_t rows_on_schedule(const std::vector<double>& times, double spacing) {
    std::size_t count = 0;
    while (count < times.size() && std::abs(times[count] - spacing * static_cast<double>(count)) < 1e-6 * spacing)
        ++count;
    return count;
}

Sampling sampling_of(const files::ArchiveReader& archive, const io::Scene& scene, const std::string& group) {
    const std::vector<double> times = archive.read(group + "/time").values;
    const double every = scene.output.sample_every;
    Sampling sampling{.end = times.empty() ? 0.0 : times.back(),
                      .spacing =
                          every == 0.0 ? scene.time.end : io::whole_interval(scene, "output.sample_every", every),
                      .samples = times.size(),
                      .warm_up = std::nullopt};
    if (every > 0.0) sampling.samples = rows_on_schedule(times, sampling.spacing);
    sampling.leaves_out_last = sampling.samples < times.size();
    if (scene.analysis.warm_up >= 0.0 && scene.analysis.warm_up < scene.time.end)
        sampling.warm_up = static_cast<std::size_t>(std::ceil(scene.analysis.warm_up / sampling.spacing - 1e-9));
    return sampling;
}

Report summary_report(const io::Scene& scene, const Sampling& sampling, measure::Recorded& recorded) {
    recorded.spacing = sampling.spacing;
    recorded.time_unit = io::renamed("s", scene.units);
    recorded.warm_up = sampling.warm_up;
    Report report;
    report.scene = scene;
    report.time = sampling.end;
    report.summary = measure::summarise(recorded);
    if (sampling.leaves_out_last)
        report.summary.note += text(
            "{}the last sample, at t = {}, comes sooner after the one before than the others and is left out of all "
            "means{}",
            report.summary.note.empty() ? "" : "; ", io::in_unit("{:.6g}", sampling.end, "s", scene.units),
            sampling.samples < 2 ? ", which are of the start alone: choose output.sample_every of at most time.end"
                                 : "");
    return report;
}

files::ResultTable result_table(const Report& report) {
    files::ResultTable table{.group = "/summary",
                             .axes = measure::axes_of(report.summary.rows),
                             .warnings = report.warnings};
    const std::string time_unit = io::renamed("s", report.scene.units);
    for (const measure::SummaryRow& row : report.summary.rows) {
        const auto add = [&](const std::string& ending, const std::string& unit, const std::string& meaning,
                             std::vector<double> values) {
            table.quantities.push_back({row.name + ending, unit, meaning, measure::names_of(row.axes)});
            table.values.push_back(std::move(values));
        };
        add("", row.unit, row.formula, mapped(row.estimates, &measure::Estimate::mean));
        add("_error", row.unit, "standard error of " + row.name + "; NaN where there is no error estimate",
            mapped(row.estimates, [](const measure::Estimate& one) { return one.error.value_or(nan); }));
        if (const auto biases = report.step_bias.of.find(row.name); biases != report.step_bias.of.end()) {
            add("_step_bias", row.unit,
                row.name + " less its value for a step of zero length; NaN where accuracy.effort does not resolve it",
                mapped(biases->second, &StepBiasEstimate::bias));
            add("_step_bias_error", row.unit, "uncertainty of that bias",
                mapped(biases->second, &StepBiasEstimate::error));
        }
        add("_autocorrelation_time", time_unit, "integrated autocorrelation time of " + row.name,
            mapped(row.estimates, &measure::Estimate::autocorrelation_time));
        if (const Prediction* prediction = measure::find_row(report.predictions, row.name))
            add("_linear", row.unit, "linear theory of " + row.name + " on the same grid", prediction->values);
    }
    table.quantities.push_back({"warm_up", time_unit, "time left out of means at the start", {}});
    table.values.push_back(
        {static_cast<double>(report.summary.warm_up) *
         (report.scene.output.sample_every == 0.0 ? report.scene.time.end : report.scene.output.sample_every)});
    return table;
}

}  // namespace drover::run
