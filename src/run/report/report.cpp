// run/report/report.cpp: the samples of an archive, their summary, and its table; the results of a run of fields beside
// their linear theory; from the differences that a run has recorded to the bias of each result.
#include "run/report/report.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "drover/base/text.hpp"
#include "measure/fields.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "physics/program_functions.hpp"
#include "run/fields/field_prediction.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/scene_support.hpp"
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
    result.recorded =
        measure::field_recording(setting, read_series(archive, field_samples_group, measure::field_observables(setting),
                                                      sampling.samples));
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
    const auto series = [&](const std::string& name) { return measure::values_of(measured.recorded.series, name); };
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

/// The rows of /step_bias that count: pieces that begin after the warm-up, comparisons after it.
struct Differences {
    std::vector<double> times;
    std::vector<double> lengths;  ///< of each piece [s]
    std::vector<double> shares;   ///< of each comparison in the time of the run
    std::vector<const double*> late, early;
};

/// Half of the step makes 1/2 (weak order 1) to 1/4 (order 2) of the bias: the difference is 1/2 to 3/4 of it.
constexpr double from_half_a_step = 5.0 / 3.0, its_error = 0.2;
constexpr double correlations_per_piece = 2.0;  // in the whole of it; the late half follows them
constexpr std::size_t min_pieces = 4;

/// Of pieces with twins, longer ones counting more.
StepBiasEstimate by_twins(const Differences& all, std::size_t k, double correlation) {
    double weights = 0.0, late = 0.0, early = 0.0;
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < all.lengths.size(); ++i) {
        if (!(all.lengths[i] >= correlations_per_piece * correlation) || !std::isfinite(all.late[i][k])) continue;
        used.push_back(i);
        weights += all.lengths[i];
        late += all.lengths[i] * all.late[i][k];
        early += all.lengths[i] * all.early[i][k];
    }
    if (used.size() < min_pieces) return {};
    late /= weights;
    early /= weights;
    double variance = 0.0;
    for (const std::size_t i : used) variance += std::pow(all.lengths[i] / weights * (all.late[i][k] - late), 2);
    // With so few pieces the error is itself uncertain: that of Student's t, twice which holds 95 %.
    const auto count = static_cast<double>(used.size());
    const double few = count / (count - 1.0) * (1.0 + 1.5 / (count - 1.0));
    const double bias = from_half_a_step * late;
    const double error = from_half_a_step * std::hypot(std::sqrt(variance) * few, 0.5 * (late - early));
    return {.bias = bias, .error = std::hypot(error, its_error * bias)};
}

/// The mean over the run of what is linear between comparisons is a sum of these times its values.
std::vector<double> shares_of(const std::vector<double>& times, double begin, double end) {
    std::vector<double> shares;
    for (std::size_t i = 0; i < times.size(); ++i) {
        const double from = i == 0 ? begin : 0.5 * (times[i - 1] + times[i]),
                     to = i + 1 == times.size() ? end : 0.5 * (times[i] + times[i + 1]);
        shares.push_back((to - from) / (end - begin));
    }
    return shares;
}

/// How much larger the error of the fields is over the run than at the comparisons, which may miss its largest values.
double unseen_error(const files::ArchiveReader& archive, double warm_up, const Differences& all) {
    const std::vector<double> times = series_of(archive, "time"), errors = series_of(archive, "step_error");
    if (errors.empty() || all.times.empty()) return 1.0;
    double run = 0.0, samples = 0.0, seen = 0.0;
    for (std::size_t i = 0; i < std::min(times.size(), errors.size()); ++i) {
        if (times[i] < warm_up) continue;
        run += errors[i];
        samples += 1.0;
    }
    for (std::size_t k = 0; k < all.times.size(); ++k) {
        const auto next = std::ranges::lower_bound(times, all.times[k] * (1.0 - 1e-9));
        const auto i = std::min(static_cast<std::size_t>(next - times.begin()), errors.size() - 1);
        seen += errors[i] * all.shares[k];
    }
    if (std::isnan(run) || std::isnan(seen)) return INFINITY;  // not resolved at some samples
    return run > 0.0 && seen > 0.0 ? std::max(1.0, run / samples / seen) : 1.0;
}

/// Of comparisons without noise: the estimated error of the fields is good to a factor of about 3.  It has no waves
/// beyond its coarse grid: where nothing changes, only a constant is known to be right.
StepBiasEstimate by_comparison(const Differences& all, std::size_t k, double unseen, bool is_constant) {
    constexpr double too_much_unseen = 3.0;
    constexpr std::size_t min_comparisons = 6;
    double sum = 0.0, size = 0.0;
    for (std::size_t i = 0; i < all.late.size(); ++i) {
        sum += all.shares[i] * all.late[i][k];
        size += all.shares[i] * std::abs(all.late[i][k]);
    }
    if (size == 0.0 && is_constant) return {0.0, 0.0};
    if (all.late.size() < min_comparisons || !std::isfinite(sum) || size == 0.0 || unseen > too_much_unseen) return {};
    return {.bias = sum, .error = unseen * size};
}

/// d ln DN/d ln N between two boxes.
StepBiasEstimate of_exponent(const StepBiasEstimate& small, double small_variance, const StepBiasEstimate& large,
                             double large_variance, double log_ratio) {
    return {(large.bias / large_variance - small.bias / small_variance) / (2.0 * log_ratio),
            std::hypot(large.error / large_variance, small.error / small_variance) / (2.0 * log_ratio)};
}

void add_boxes(const std::vector<std::string>& densities, const measure::Summary& summary, StepBiases& biases) {
    for (const measure::BoxFamily& family : measure::box_families())
        for (const std::string& what : densities) {
            const std::string start = what + "_number";
            const auto variance = biases.of.find(start + "_variance" + family.ending);
            const auto row_of = [&](const char* result) {
                return measure::find_row(summary.rows, start + result + family.ending);
            };
            const measure::SummaryRow *number = row_of(""), *deviation = row_of("_deviation");
            if (variance == biases.of.end() || number == nullptr || deviation == nullptr) continue;
            const auto mean = [](const measure::SummaryRow& row, std::size_t b) { return row.estimates[b].mean; };
            std::vector<StepBiasEstimate> roots, exponents;
            const std::vector<StepBiasEstimate>& of = variance->second;
            for (std::size_t b = 0; b < of.size(); ++b) {
                const double root = mean(*deviation, b);
                roots.push_back({of[b].bias / (2.0 * root), of[b].error / (2.0 * root)});  // of that of a variance
                exponents.emplace_back();
                if (b + 1 < of.size())
                    exponents.back() = of_exponent(of[b], root * root, of[b + 1], std::pow(mean(*deviation, b + 1), 2),
                                                   std::log(mean(*number, b + 1) / mean(*number, b)));
            }
            biases.of[start + "_deviation" + family.ending] = std::move(roots);
            biases.of[start + "_exponent" + family.ending] = std::move(exponents);
        }
}

/// From what the archive of a run of fields has recorded, for the rows of its summary.
/// is_exact: every term is linear.
StepBiases step_biases(const files::ArchiveReader& archive, const io::Scene& scene, bool is_exact,
                       const BiasedRows& measured, const measure::Summary& summary) {
    StepBiases biases;
    for (const std::string& density : measured.densities) biases.exact.push_back(density + "_number");
    biases.state = is_exact ? StepBiasState::exact : step_bias_state(scene);
    const std::string group = step_bias_group;
    if (biases.state == StepBiasState::measured && (!measured.has_all || !archive.has(group + "/late")))
        biases.state = StepBiasState::not_measured;
    if (biases.state != StepBiasState::measured) return biases;
    const std::vector<double> times = archive.read(group + "/time").values,
                              steps = archive.read(group + "/steps").values,
                              late = archive.read(group + "/late").values,
                              early = archive.read(group + "/early").values;
    std::size_t size = 0;
    for (const BiasedRows::Row& row : measured.rows) size += row.values;
    const bool noisy = io::has_noise(scene);
    const double warm_up = static_cast<double>(summary.warm_up) *
                           (scene.output.sample_every > 0.0 ? scene.output.sample_every : scene.time.end);
    Differences differences;
    for (std::size_t i = 0; i < times.size() && (i + 1) * size <= late.size(); ++i) {
        const double length = noisy ? steps[i] * scene.time.dt : 0.0;
        if (steps[i] == 0.0 || times[i] - length < warm_up * (1.0 - 1e-9)) continue;
        differences.times.push_back(times[i]);
        differences.lengths.push_back(length);
        differences.late.push_back(late.data() + i * size);
        differences.early.push_back(early.data() + i * size);
    }
    const std::vector<double> samples = archive.read(std::string(field_samples_group) + "/time").values;
    if (!samples.empty() && samples.back() > warm_up)
        differences.shares = shares_of(differences.times, warm_up, samples.back());
    else differences.shares.assign(differences.times.size(), 0.0);
    const double unseen = noisy ? 1.0 : unseen_error(archive, warm_up, differences);
    std::size_t first = 0;
    for (const auto& [name, values, is_of_model, is_of_shells] : measured.rows) {
        const measure::SummaryRow* summarised = measure::find_row(summary.rows, name);
        for (std::size_t k = 0; k < values && is_of_model; ++k) {
            const measure::Estimate* estimate =
                summarised && k < summarised->estimates.size() ? &summarised->estimates[k] : nullptr;
            const double correlation = estimate ? estimate->autocorrelation_time : NAN;
            const bool is_constant = estimate && estimate->error && *estimate->error == 0.0;
            if (noisy) biases.of[name].push_back(by_twins(differences, first + k, correlation));
            else if (is_of_shells && !measured.has_shell[k % measured.has_shell.size()]) biases.of[name].emplace_back();
            else biases.of[name].push_back(by_comparison(differences, first + k, unseen, is_constant));
        }
        first += values;
    }
    add_boxes(measured.densities, summary, biases);
    return biases;
}

/// Of results that are wrong by more than a tenth, beyond their uncertainties: one warning at most.
std::vector<std::string> step_bias_warnings(const StepBiases& biases, const io::Scene& scene,
                                            const measure::Summary& summary) {
    constexpr double large = 0.1;
    std::string worst;
    double worst_ratio = large;
    std::size_t others = 0;
    for (const measure::SummaryRow& row : summary.rows)
        for (std::size_t k = 0; k < row.estimates.size(); ++k) {
            const StepBiasEstimate* found = biases.find(row.name, k);
            const measure::Estimate& estimate = row.estimates[k];
            const double size = std::abs(estimate.mean), scatter = estimate.error.value_or(NAN);
            if (found == nullptr || !found->is_resolved() || !(size > 10.0 * scatter)) continue;
            // Of several hundred numbers some exceed two standard errors by chance.
            if (!(std::abs(found->bias) > 3.0 * found->error)) continue;
            const double ratio = std::abs(found->bias) / size;
            if (!(ratio > large)) continue;
            ++others;
            if (ratio <= worst_ratio) continue;
            worst_ratio = ratio;
            worst = row.name;
            if (!row.axes.empty() && row.axes.size() == 1)
                worst += text(" at {} = {:.3g} {}", row.axes[0].name, row.axes[0].values[k], row.axes[0].unit);
            worst += text(" by {}", step_bias_text(biases, scene, row.name, k, estimate));
        }
    if (worst.empty()) return {};
    return {text("the time step biases {}{}; expected less than {:.0f} %: choose time.dt = {}", worst,
                 others > 1 ? text(", and {} other numbers by more than a tenth", others - 1) : "", 100.0 * large,
                 scene.time.dt * std::exp2(-std::ceil(std::log2(worst_ratio / large))))};
}
}  // namespace

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

const StepBiasEstimate* StepBiases::find(const std::string& row, std::size_t component) const {
    const auto found = of.find(row);
    return found == of.end() || component >= found->second.size() ? nullptr : &found->second[component];
}

std::string step_bias_text(const StepBiases& biases, const io::Scene& scene, const std::string& row,
                           std::size_t component, const measure::Estimate& estimate) {
    if (biases.state == StepBiasState::exact || std::ranges::find(biases.exact, row) != biases.exact.end())
        return "exact";
    const StepBiasEstimate* found = biases.find(row, component);  // none where it is not measured
    if (found == nullptr) return "not measured";
    const double size = std::abs(estimate.mean);
    const std::string unresolved = text("not resolved (effort {:.3g} %)", 100.0 * scene.accuracy.effort);
    if (!found->is_resolved()) return unresolved;
    if (found->bias == 0.0 && found->error == 0.0) return "0";
    if (!(size > 2.0 * estimate.error.value_or(0.0)))  // a mean that may be zero has no relative error
        return text("{} +- {:.1g}", measured_text(found->bias, found->error), found->error);
    const double percent = 100.0 * found->bias / size, error = 100.0 * found->error / size;
    constexpr double too_uncertain = 100.0;  // per cent
    if (error > too_uncertain) return unresolved;
    return text("{}{} +- {:.1g} %", percent > 0.0 ? "+" : "", measured_text(percent, error), error);
}

}  // namespace drover::run
