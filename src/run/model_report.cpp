// run/model_report.cpp: the results of a run of a declared model, and its warnings.
#include <algorithm>
#include <cmath>
#include <map>

#include "drover/measure/model_fields.hpp"
#include "drover/model/theory.hpp"
#include "drover/numerics/shells.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/report.hpp"
#include "drover/run/warnings.hpp"
#include "run/growing_waves.hpp"
#include "run/model_stability.hpp"
#include "run/sample_recording.hpp"
#include "run/text_resolution.hpp"

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

void warn_of_tails(const io::Scene& scene, const model::Equations& equations, const measure::ModelSetting& setting,
                   const std::vector<measure::RecordedSeries>& series, std::vector<std::string>& warnings) {
    // Noise feeds all waves, so that the tail says nothing about the products.
    if (equations.degree() == 1 || equations.has_noise()) return;
    for (const measure::MeasuredField& field : setting.fields) {
        if (field.first >= setting.of_state) break;  // what is in balance follows the others
        const auto *tails = measure::find_row(series, "spectral_tail_" + field.name),
                   *variances = measure::find_row(series, "variance_" + field.name);
        if (tails == nullptr || variances == nullptr) continue;
        const double tail = worst_tail(*tails, *variances);
        if (tail > max_spectral_tail)
            warnings.push_back(
                text("the grid does not resolve {}: {:.2g} of its variance is in the shortest waves "
                     "(spectral_tail_{}); expected less than {}: choose {}",
                     field.name, tail, field.name, max_spectral_tail, grid_keys(scene.grid, 2)));
    }
}

/// Whether the noise of a density depends on it.
bool multiplies_itself(const model::Equations& equations, const measure::MeasuredField& field) {
    if (!equations.has_product_noise()) return false;
    const int place = equations.state_components()[static_cast<std::size_t>(field.first)];
    const numerics::Wavevector q{1.0, 0.0};
    model::UniformState state = equations.reference(), thinner = state;
    thinner[static_cast<std::size_t>(place)] *= 0.999;  // not far away, where the strength may have no value
    return equations.noise(state, q)(place, place) != equations.noise(thinner, q)(place, place);
}

double kept_modes(const numerics::Grid& grid, int degree) {
    double count = 0.0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(grid.ny); ++row)
        for (std::size_t column = 0; column < numerics::columns(grid); ++column)
            if (numerics::is_kept(grid, degree, column, row)) count += numerics::mode_weight(grid, column);
    return count;
}

/// Gaussian noise of a density is that of particles only where each mode has many: white fluctuations of particles have
/// the structure factor n, of which the shortest waves, where noise and diffusion are alone, are the measure.
void warn_of_few_particles(const model::Equations& equations, const measure::ModelSetting& setting,
                           const std::vector<measure::RecordedSeries>& series, const measure::Summary& summary,
                           std::vector<std::string>& warnings) {
    constexpr double fewest = 10.0;
    const numerics::Grid& grid = setting.grid.grid;
    for (const measure::MeasuredField& field : setting.fields) {
        if (!field.is_density || !multiplies_itself(equations, field)) continue;
        const auto *powers = measure::find_row(summary, "structure_factor_" + field.name),
                   *means = measure::find_row(summary, "mean_" + field.name);
        if (powers == nullptr || means == nullptr) continue;
        const double mean = means->estimates.front().mean, shortest = powers->estimates.back().mean;
        const double particles =
            mean * mean * numerics::area(grid) / (shortest * kept_modes(grid, setting.grid.degree));
        if (!(particles < fewest)) continue;
        const auto* least = measure::find_row(series, "min_" + field.name);
        const auto below = least == nullptr ? 0
                                            : std::count_if(least->values.begin(), least->values.end(),
                                                            [](double value) { return value < 0.0; });
        warnings.push_back(
            text("the noise of {} depends on {}, whose shortest waves fluctuate as with {:.2g} particles for each kept "
                 "mode{}; expected {} or more, or Gaussian noise does not describe particles: choose a coarser grid or "
                 "a larger density",
                 field.name, field.symbol, particles,
                 below > 0 ? text(", and it is below 0 somewhere in {} of {} samples", below, least->values.size())
                           : "",
                 fewest));
    }
}
}  // namespace

std::vector<std::string> model_warnings(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    std::vector<std::string> warnings =
        model::start_warnings(io::start_of(scene), equations, scene.grid, io::kept_degree(scene, equations));
    if (std::string cut = growing_waves_warning(equations.linear_system(scene.grid, io::kept_degree(scene, equations)));
        !cut.empty())
        warnings.push_back(std::move(cut));
    if (!equations.has_finite_degree())
        warnings.emplace_back(
            "some functions of the equations are no polynomials: their aliases are not removed exactly; compare with a "
            "run on twice the points");
    if (const double rate = equations.explicit_rate(scene.grid), part = rate * scene.time.dt;
        part > 1.0 && scene.time.tolerance == 0.0)
        warnings.push_back(text(
            "the terms that name an axis, or depend on position or time, change the waves of the grid at up to {:.3g} "
            "/s: {:.3g} in a step of time.dt = {}; expected less than 1, or the run may diverge: choose time.dt = "
            "{:.2g}, or a coarser grid",
            rate, part, scene.time.dt, scene.time.dt / (2.0 * part)));
    for (std::string& warning : text_resolution_warnings(scene)) warnings.push_back(std::move(warning));
    if (scene.initial.kind != "uniform" || equations.has_noise()) return warnings;
    if (equations.uniform_rates(equations.reference()).cwiseAbs().maxCoeff() == 0.0)
        warnings.emplace_back(
            "the start is uniform, stationary and without noise: nothing will change; choose another initial.kind, "
            "such as \"random\"");
    return warnings;
}

namespace {
/// Of a sample, the values of all components: fields in balance are replaced by those that follow.
model::UniformState mean_state(const model::Equations& equations, const measure::ModelSetting& setting,
                               const measure::Summary& summary) {
    model::UniformState state = equations.reference();
    for (std::size_t c = 0; c < static_cast<std::size_t>(setting.of_state); ++c)
        if (const auto* row = measure::find_row(summary, "mean_" + setting.components[c].name))
            state[static_cast<std::size_t>(equations.state_components()[c])] = row->estimates.front().mean;
    return state;
}

/// Structure factors and number fluctuations by the linear theory about the state nearest to the means of the run.
/// About an ordered state the order is turned to the direction of its mean.
void predict(const model::Equations& equations, const measure::ModelSetting& setting, Threads& threads,
             Report& report) {
    if (!equations.has_noise()) {
        report.no_prediction = "without noise the stationary state of the linear theory is uniform";
        return;
    }
    const model::StationaryStates found = model::stationary_states(equations);
    if (found.states.empty()) {
        report.no_prediction = "there is no uniform stationary state: " + found.why_none;
        return;
    }
    const model::UniformState mean = mean_state(equations, setting, report.summary);
    const model::StationaryState* const nearest = model::nearest_state(found, equations.model(), mean);
    if (nearest->is_of_family) {
        report.no_prediction =
            "the stationary states are a continuum, such as all phases of an amplitude, of which the theory has one";
        return;
    }
    const numerics::Grid& grid = setting.grid.grid;
    const model::StructureFactors modes =
        model::structure_factors(equations, *nearest, grid, setting.grid.degree, threads);
    if (!modes.why_none.empty()) {
        report.no_prediction = text("the linear theory about the state \"{}\" has none: {}; see drover stability",
                                    nearest->name, modes.why_none);
        return;
    }
    report.about = text("the state \"{}\", {}", nearest->is_isotropic ? "isotropic" : "ordered",
                        state_text(equations.model(), nearest->values));
    report.about_flock = !nearest->is_isotropic;
    if (report.about_flock) report.about += ", with its order along x";
    std::size_t part = 0;
    std::map<std::string, std::vector<std::size_t>> parts_of;  // of each field
    for (const model::Field& field : equations.model().fields)
        for (int k = 0; k < model::components(field); ++k) parts_of[field.name].push_back(part++);
    const auto powers_of = [&](std::size_t i, std::size_t j) {
        std::vector<double> powers;
        for (std::size_t m = 0; m < numerics::modes(grid); ++m) powers.push_back(modes.at(m, i, j).real());
        return powers;
    };
    const auto add = [&](const std::string& name, std::size_t i, std::size_t j) {
        report.predictions.push_back({name, numerics::shell_means(grid, setting.grid.shells, powers_of(i, j))});
    };
    for (const measure::MeasuredField& field : setting.fields) {
        const std::vector<std::size_t>& parts = parts_of.at(field.name);
        const std::string name = "structure_factor_" + field.name;
        if (field.spin == 0) add(name, parts[0], parts[0]);
        else {
            add(name + "_along", parts[0], parts[0]);
            add(name + "_across", parts[1], parts[1]);
        }
        if (field.is_density) predict_boxes(field.name, powers_of(parts[0], parts[0]), report);
    }
    for (const measure::MeasuredField& a : setting.fields)
        for (const measure::MeasuredField& b : setting.fields)
            if (a.first < b.first && a.spin == 0 && b.spin == 0)
                add("structure_factor_" + a.name + "_" + b.name, parts_of.at(a.name)[0], parts_of.at(b.name)[0]);
}
}  // namespace

namespace {
BiasedRows biased_rows_of(measure::ModelSetting setting) {
    setting.grid.watches_error = false;
    std::vector<std::string> densities;
    for (const measure::MeasuredField& field : setting.fields)
        if (field.is_density) densities.push_back(field.name);
    return biased_rows(measure::model_observables(setting), std::move(densities));
}
}  // namespace

Report make_model_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory) {
    const model::Equations equations(io::model_of(scene.declared));
    // Archives of before November 2026 have no estimate.
    const bool watches = scene.time.max_error > 0.0 && archive.has(std::string(field_samples_group) + "/step_error");
    const std::vector<model::StateComponent> balanced = model::components_in_balance(equations);
    const bool with_balanced =
        !balanced.empty() && archive.has(std::string(field_samples_group) + "/mean_" + balanced.front().name);
    const measure::ModelSetting setting =
        measure::make_model_setting(equations, scene.grid, io::kept_degree(scene, equations), watches, with_balanced);
    const Sampling sampling = sampling_of(archive, scene, field_samples_group);
    measure::Recorded recorded =
        measure::model_recording(setting, read_series(archive, field_samples_group, measure::model_observables(setting),
                                                      sampling.samples));
    Report report = summary_report(scene, sampling, recorded);
    report.setting = setting.grid;
    report.step_bias =
        step_biases(archive, scene, !equations.has_explicit_part(), biased_rows_of(setting), report.summary);
    if (theory == Theory::included) {
        Threads threads(choose_threads(scene));
        predict(equations, setting, threads, report);
    }
    report.warnings = model_warnings(scene);
    warn_of_tails(scene, equations, setting, recorded.series, report.warnings);
    warn_of_few_particles(equations, setting, recorded.series, report.summary, report.warnings);
    add_step_error(archive, scene, report.warnings);
    for (std::string& warning : step_bias_warnings(report.step_bias, scene, report.summary))
        report.warnings.push_back(std::move(warning));
    return report;
}

}  // namespace drover::run
