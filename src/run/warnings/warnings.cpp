// run/warnings/warnings.cpp: resolution, errors of the time step, values that are not finite, and noise of few
// particles.
#include "run/warnings/warnings.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "io/units.hpp"
#include "measure/fields.hpp"
#include "model/start.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/time_method.hpp"
#include "run/fields/field_prediction.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/fields/step_bias.hpp"

namespace drover::run {

std::vector<double> series_of(const files::ArchiveReader& archive, const std::string& name) {
    const std::string dataset = std::string(field_samples_group) + "/" + name;
    return archive.has(dataset) ? archive.read(dataset).values : std::vector<double>();
}

namespace {
/// The size of a field where products matter, its first component in the equations being `at`: the mean of a density;
/// the order of bodies that all point along it (their mean or, in the unit of their density, their sum), or that of an
/// ordered uniform state if it is smaller.  0: unknown.
double scale_of(const model::Equations& equations, const model::Field& field, std::size_t at,
                const theory::StationaryStates& found) {
    if (field.spin == 0) return std::max(0.0, equations.reference()[at]);
    double scale = 0.0;
    if (field.unit == "1" && !field.observed.of.empty()) scale = 1.0;
    for (const model::Field& other : equations.model().fields)
        if (other.symbol == field.observed.of && other.unit == field.unit) scale = other.reference;
    for (const theory::StationaryState& state : found.states)
        if (const double size = std::hypot(state.values[at], state.values[at + 1]); size > 0.0)
            scale = scale > 0.0 ? std::min(scale, size) : size;
    return scale;
}

/// None where the theory has none about the references.
theory::StationaryStates states_of(const io::Scene& scene, const model::Equations& equations) try {
    return placed_term_of(scene, equations).empty() ? stationary_states_of(scene, equations)
                                                    : theory::StationaryStates();
} catch (const Error& error) {
    if (error.fault() != Fault::input) throw;
    return {};
}

/// The variance that noise maintains in the shortest waves of the grid, of each component of the equations.
using TailPowers = std::vector<double>;

/// By the isotropic linear part about the references; modes that grow have no powers.
TailPowers isotropic_tail(const model::Equations& equations, const numerics::System& system) {
    const numerics::Grid& grid = system.grid;
    const numerics::DistinctWavenumbers wavenumbers = numerics::distinct_wavenumbers(grid, system.degree);
    const std::size_t width = numerics::columns(grid);
    std::vector<double> weight(wavenumbers.q.size());
    for (std::size_t m = 0; m < wavenumbers.of_mode.size(); ++m)
        if (const std::int32_t n = wavenumbers.of_mode[m];
            n >= 0 && measure::is_in_tail(grid, system.degree, m % width, m / width))
            weight[static_cast<std::size_t>(n)] += numerics::mode_weight(grid, m % width);
    const numerics::BlockParts parts = numerics::block_parts(system.layout);
    TailPowers powers(static_cast<std::size_t>(equations.components()), 0.0);
    for (std::size_t n = 0; n < weight.size(); ++n) {
        if (weight[n] == 0.0) continue;
        const numerics::IsotropicBlocks rates = system.linear(wavenumbers.q[n]), noise = system.noise(wavenumbers.q[n]);
        for (const auto& [block, driven, members] :
             {std::tuple{&rates.even, &noise.even, &parts.even}, std::tuple{&rates.odd, &noise.odd, &parts.odd}}) {
            if (block->size == 0) continue;
            try {
                const numerics::Block found = numerics::stationary_covariance(*block, *driven);
                for (int k = 0; k < found.size; ++k) {
                    const int array = (*members)[static_cast<std::size_t>(k)].component;
                    const int place = equations.state_components()[static_cast<std::size_t>(array)];
                    powers[static_cast<std::size_t>(place)] += weight[n] * found(k, k) / numerics::area(grid);
                }
            } catch (const Error& error) {  // it grows
                if (error.fault() != Fault::run) throw;
            }
        }
    }
    return powers;
}

/// By linear theory about the state of the run, or about the references where there is no such theory.  Nothing: noise
/// that depends on the fields has no strength of its own at the references.
std::optional<TailPowers> tail_powers(const io::Scene& scene, const model::Equations& equations,
                                      const numerics::System& system, const files::ArchiveReader& archive) {
    const numerics::Grid& grid = system.grid;
    TailPowers powers(static_cast<std::size_t>(equations.components()), 0.0);
    if (!equations.has_noise()) return powers;
    constexpr std::size_t max_points = std::size_t{256} * 256;  // beyond, it takes longer than all else
    if (numerics::points(grid) <= max_points) {
        Threads one(1);
        constexpr std::size_t max_samples = 64;  // samples of the second half of the run
        const std::size_t count = series_of(archive, "time").size(), width = numerics::columns(grid);
        const auto series = [&](const std::string& name) { return series_of(archive, name); };
        std::vector<PartPair> parts;
        for (std::size_t k = 0; k < powers.size(); ++k) parts.emplace_back(k, k);
        const auto is_in_tail = [&](std::size_t m) {
            return measure::is_in_tail(grid, system.degree, m % width, m / width);
        };
        const FieldPrediction predicted =
            predicted_fields(scene, equations,
                             sampled_means(equations, series, count / 2,
                                           std::max<std::size_t>(1, count / 2 / max_samples)),
                             parts, system.degree, one, is_in_tail);
        if (!predicted.why_none) {
            for (std::size_t m = 0; m < numerics::modes(grid); ++m)
                for (std::size_t k = 0; k < powers.size(); ++k)
                    powers[k] += numerics::mode_weight(grid, m % width) * predicted.powers[k][m] / numerics::area(grid);
            return powers;
        }
    }
    if (equations.has_product_noise() || !system.noise) return std::nullopt;
    return isotropic_tail(equations, system);
}

/// The tail of one field at its worst.
struct Tail {
    double fraction = 0.0;  ///< of the variance of the field
    double time = 0.0;
};

/// The largest tail of the samples that count.  Those are samples whose tail the run has built up, not those in which
/// short waves of the start still decay, and whose tail is larger than `min_power` [unit of the field, squared]: a
/// field that is still or by now negligible needs no resolution.
Tail worst_tail(bool judges_transients, const std::vector<double>& times, const std::vector<double>& tails,
                const std::vector<double>& variances, double min_power) {
    Tail worst;
    for (std::size_t i = 1; i < tails.size(); ++i) {
        const double power = tails[i] * variances[i];
        const bool is_late = times[i] >= 0.5 * times.back(),
                   is_built_up = judges_transients && power > 2.0 * tails[0] * variances[0];
        if ((is_late || is_built_up) && power > min_power && tails[i] > worst.fraction)
            worst = {.fraction = tails[i], .time = times[i]};
    }
    return worst;
}

/// By how much a tail must exceed what linear theory predicts: on the average over the second half of a run, or in one
/// sample, where a single mode of noise may exceed its mean by the logarithm of their number.
double excess_over_linear(const std::vector<double>& tails, const std::vector<double>& variances, double predicted) {
    const std::size_t half = tails.size() / 2;
    double mean = 0.0;
    for (std::size_t i = half; i < tails.size(); ++i)
        mean += tails[i] * variances[i] / static_cast<double>(tails.size() - half);
    return mean > max_tail_over_linear * predicted ? max_tail_over_linear
                                                   : max_tail_over_linear + std::log(static_cast<double>(tails.size()));
}

/// Points that would resolve a field with this tail.  Steepening fronts on 64 to 512 points: the tail falls as 1/N at
/// first, then at least as 1/N^2, and exponentially once the width of the front is resolved.
int points_that_resolve(int points, double tail) {
    const double excess = tail / max_spectral_tail, factor = std::min({excess, 2.0 * std::sqrt(excess), 32.0});
    int result = 2 * points;
    while (result < factor * points) result *= 2;
    return result;
}

/// Whether deviations of a field from its mean are rounding errors of its values.  One that starts at 0 has rounding
/// errors of what other fields make of it, and no size to compare with but its unit.
bool is_rounding(const files::ArchiveReader& archive, const model::Field& field, const std::vector<double>& variances) {
    constexpr double rounding = 1e-10;
    double size = 0.0, at_start = 0.0;  // the largest on the grid
    for (const std::string& name : {"min_" + field.name, "max_" + field.name, "largest_" + field.name}) {
        const std::vector<double> values = series_of(archive, name);
        for (const double value : values) size = std::max(size, std::abs(value));
        if (!values.empty()) at_start = std::max(at_start, std::abs(values.front()));
    }
    if (at_start == 0.0) size = std::max(size, 1.0);
    return *std::ranges::max_element(variances) < rounding * rounding * size * size;
}

void add_resolution(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                    std::vector<std::string>& warnings) {
    if (!what.equations.has_explicit_part()) return;
    const numerics::System system = what.equations.linear_system(scene.grid, what.kept_degree);
    const std::vector<double> times = series_of(archive, "time");
    std::optional<TailPowers> powers;  // take longer than all else
    for (const auto& [field, at] : model::placed_fields(what.equations.model())) {
        if (field.left != model::LeftSide::rate) continue;  // what is in balance follows the others
        const std::vector<double> tails = series_of(archive, "spectral_tail_" + field.name),
                                  variances = series_of(archive, "variance_" + field.name);
        if (tails.size() < 2 || variances.size() != tails.size() || times.size() != tails.size() ||
            *std::ranges::max_element(tails) <= max_spectral_tail)
            continue;
        const double own = *std::ranges::max_element(variances),
                     scale = scale_of(what.equations, field, at, states_of(scene, what.equations));
        if (own == 0.0 || (scale == 0.0 && is_rounding(archive, field, variances))) continue;
        const double min_power = scale > 0.0 ? max_spectral_tail * std::max(max_spectral_tail * scale * scale, own)
                                             : 1e-12 * own;  // not of rounding
        Tail worst = worst_tail(scale > 0.0, times, tails, variances, min_power);
        if (worst.fraction <= max_spectral_tail) continue;
        if (!powers) powers = tail_powers(scene, what.equations, system, archive);
        if (!powers) return;
        const auto begin = powers->begin() + static_cast<std::ptrdiff_t>(at);
        const double predicted = std::accumulate(begin, begin + model::components(field), 0.0);
        const double by_noise = excess_over_linear(tails, variances, predicted) * predicted;
        worst = worst_tail(scale > 0.0, times, tails, variances, std::max(min_power, by_noise));
        if (worst.fraction <= max_spectral_tail) continue;
        const std::string smoothing = key_of_term(scene, what.equations, field, "lap " + field.symbol);
        numerics::Grid finer = scene.grid;
        const auto points = [&](int now) { return scale > 0.0 ? points_that_resolve(now, worst.fraction) : 2 * now; };
        finer.nx = points(finer.nx);
        if (finer.ny > 1) finer.ny = points(finer.ny);
        warnings.push_back(
            text("the grid does not resolve {} with {}: {:.2g} of its variance is in the shortest waves of the grid at "
                 "t = {} (spectral_tail_{}); expected less than {}: choose {}{}; a step that is too "
                 "long has the same effect: try time.dt = {}",
                 field.name, grid_keys(scene.grid), worst.fraction, io::in_unit("{:.6g}", worst.time, "s", scene.units),
                 field.name, max_spectral_tail, grid_keys(finer), smoothing.empty() ? "" : ", or a larger " + smoothing,
                 0.5 * scene.time.dt));
    }
}

void add_not_finite(const files::ArchiveReader& archive, const io::Scene& scene, const model::Equations& equations,
                    std::vector<std::string>& warnings) {
    std::vector<std::string> names;
    for (const model::Field& field : equations.model().fields)
        for (const char* what : {"variance_", "spectral_tail_"}) {
            // Others may be undefined, such as the alignment with a flow at rest.
            const std::vector<double> values = series_of(archive, what + field.name);
            if (std::ranges::any_of(values, [](double value) { return !std::isfinite(value); }))
                names.push_back(what + field.name);
        }
    if (names.empty()) return;
    warnings.push_back(
        text("not finite in at least one sample: {}; the run diverged: choose a smaller time.dt than {}, or add a "
             "term that limits growth",
             joined(names), scene.time.dt));
}

/// Whether the noise of a density depends on it.
bool multiplies_itself(const model::Equations& equations, int component) {
    if (equations.placed_noise() != nullptr) return false;  // not known without a uniform state
    const numerics::Wavevector q{1.0, 0.0};
    model::UniformState state = equations.reference(), thinner = state;
    thinner[static_cast<std::size_t>(component)] *= 0.999;  // not far away, where the strength may have no value
    return equations.noise(state, q)(component, component) != equations.noise(thinner, q)(component, component);
}

/// The mean of the second half of a series of arrays.
double late_mean(const std::vector<double>& values, std::size_t samples, std::size_t entry) {
    const std::size_t width = values.size() / samples, first = samples / 2;
    double sum = 0.0;
    for (std::size_t i = first; i < samples; ++i) sum += values[i * width + std::min(entry, width - 1)];
    return sum / static_cast<double>(samples - first);
}

/// Gaussian noise of a density is that of particles only where each mode has many: white fluctuations of particles have
/// the structure factor n, of which the shortest waves, where noise and diffusion are alone, are the measure.
void add_few_particles(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                       std::vector<std::string>& warnings) {
    constexpr double fewest = 10.0;
    const model::Equations& equations = what.equations;
    if (!equations.has_product_noise()) return;
    const std::size_t samples = series_of(archive, "time").size();
    for (const auto& [field, first] : model::placed_fields(equations.model())) {
        const auto here = static_cast<int>(first);
        if (model::counted_by(field).empty() || !multiplies_itself(equations, here)) continue;
        const std::vector<double> powers = series_of(archive, "structure_factor_" + model::short_name(field)),
                                  means = series_of(archive, "mean_" + field.name);
        if (samples == 0 || powers.size() < samples || means.size() != samples) continue;
        const double mean = late_mean(means, samples, 0), shortest = late_mean(powers, samples, powers.size());
        const double modes_per_area = model::noise_moment(scene.grid, what.kept_degree, 0, 0);
        const double particles = mean * mean / (shortest * modes_per_area);
        if (!(particles < fewest)) continue;
        const std::vector<double> minima = series_of(archive, "min_" + field.name);
        const auto below = std::ranges::count_if(minima, [](double value) { return value < 0.0; });
        warnings.push_back(
            text("the noise of {} depends on {}, whose shortest waves fluctuate like {:.2g} particles for each kept "
                 "mode{}; expected {} or more, since Gaussian noise does not describe fewer particles: choose a "
                 "coarser grid or a larger density",
                 field.name, field.symbol, particles,
                 below > 0 ? text(", and it is below 0 somewhere in {} of {} samples", below, minima.size()) : "",
                 fewest));
    }
}

/// Of a run whose estimated error has exceeded time.max_error.
void add_step_error(const files::ArchiveReader& archive, const io::Scene& scene, bool has_product_noise,
                    std::vector<std::string>& warnings) {
    const std::vector<double> errors = series_of(archive, "step_error"), times = series_of(archive, "time");
    if (errors.empty() || times.size() != errors.size() || scene.time.max_error == 0.0) return;
    const auto is_unknown = [](double error) { return std::isnan(error); };
    const auto unknown = std::ranges::count_if(errors, is_unknown);
    const auto first = std::ranges::find_if(errors, is_unknown);
    if (unknown > 0 && scene.time.max_error < 1.0)
        warnings.push_back(text(
            "the error of the time steps is not resolved at {} of {} samples, first at t = {} (effort "
            "{:.3g} %); expected an estimate: increase accuracy.effort, or set time.max_error = 1 to turn off this "
            "warning",
            unknown, errors.size(),
            io::in_unit("{:.6g}", times[static_cast<std::size_t>(first - errors.begin())], "s", scene.units),
            100.0 * effort_of_estimates(scene)));
    const auto worst = std::ranges::max_element(errors, [](double a, double b) {
        return (std::isnan(a) ? 0.0 : a) < (std::isnan(b) ? 0.0 : b);
    });
    if (std::isnan(*worst)) return;
    const std::string when =
        io::in_unit("{:.6g}", times[static_cast<std::size_t>(worst - errors.begin())], "s", scene.units);
    // A step that was chosen for means need not follow the noise path more closely than this.
    constexpr double decoupled = 0.3;
    const double allowed = std::max(scene.time.max_error, scene.found.step.by == io::ChosenBy::means ? decoupled : 0.0);
    if (*worst <= allowed) return;
    // dt may be no more than an interval of outputs; no tolerance sees the error of noise that multiplies fields.
    if (scene.time.tolerance > 0.0 && !has_product_noise) {
        warnings.push_back(
            text("the steps of {} are too inaccurate: their estimated error is {:.2g} of a field's fluctuation at "
                 "t = {} (step_error); expected at most time.max_error = {}: choose time.tolerance = {:.1g}",
                 scene.time.stepper, *worst, when, scene.time.max_error,
                 std::max(1e-3 * scene.time.tolerance, 0.5 * scene.time.tolerance * scene.time.max_error / *worst)));
        return;
    }
    // With noise the methods have order 1.5 to 2; noise that multiplies fields limits all of them to 1/2.
    const double order = has_product_noise      ? 0.5
                         : io::has_noise(scene) ? 1.5
                                                : numerics::time_method(scene.time.stepper).order;
    constexpr double max_halvings = 20.0;  // of an error that is infinite
    const double halvings = std::min(max_halvings, std::ceil(std::log2(*worst / scene.time.max_error) / order));
    warnings.push_back(
        text("time.dt = {} is too long: its estimated error is {:.2g} of a field's fluctuation at t = {} "
             "(step_error){}; expected "
             "at most time.max_error = {}: choose time.dt = {}{}{}",
             scene.time.dt, *worst, when,
             *worst >= 1.0 ? ", so the fields are unrelated to the exact ones, and at best their means are right" : "",
             scene.time.max_error, scene.time.dt * std::exp2(-halvings),
             order > 0.5 && order < 4.0 && scene.time.stepper != "etdrk4-krogstad"
                 ? ", or time.stepper = \"etdrk4-krogstad\""
                 : "",
             scene.found.step.by == io::ChosenBy::means
                 ? " if the fields matter; it was chosen for means, whose column is step"
                 : ""));
}

/// Means so far from the state of the exact linear part that the fields stand still: their step error cannot tell.
void add_standstill(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                    std::vector<std::string>& warnings) {
    const model::Equations& compiled = what.equations;
    const std::vector<model::StateComponent> components = model::components_of_state(compiled);
    model::UniformState means = compiled.reference();
    const auto mean_of = [&](std::size_t c) -> double& {
        return means[static_cast<std::size_t>(compiled.state_components()[c])];
    };
    for (std::size_t c = 0; c < components.size(); ++c) {
        const std::vector<double> series = series_of(archive, "mean_" + components[c].name);
        if (series.empty() || !std::isfinite(series.back())) return;
        mean_of(c) = series.back();
    }
    if (scene.initial.formulas.empty() && means == compiled.reference()) return;
    const model::Equations equations = about_start(scene, what).equations;
    if (!stands_still(scene, equations, means)) return;
    std::vector<std::string> far;
    for (std::size_t c = 0; c < components.size(); ++c)
        if (mean_of(c) != equations.reference()[static_cast<std::size_t>(equations.state_components()[c])])
            far.push_back(text("{} = {:.3g}", components[c].name, mean_of(c)));
    if (far.empty()) return;
    warnings.push_back(
        text("a step of time.dt = {} reproduces less than half of the slow changes about the last means ({}): the "
             "exact linear part is taken about other values, is fast here and is nearly cancelled by the other terms, "
             "an error that step_error does not detect; set these means as references of the fields, or choose a "
             "shorter time.dt",
             scene.time.dt, joined(far)));
}

}  // namespace

std::vector<std::string> field_warnings(const files::ArchiveReader& archive, const io::Scene& scene,
                                        const model::Integrated& what) {
    std::vector<std::string> warnings = field_scene_warnings(scene, what);
    add_not_finite(archive, scene, what.equations, warnings);
    add_resolution(archive, scene, what, warnings);
    add_density_warnings(archive, scene, what, warnings);
    add_few_particles(archive, scene, what, warnings);
    add_step_error(archive, scene, what.equations.has_product_noise(), warnings);
    add_late_order(archive, scene, what, warnings);
    add_standstill(archive, scene, what, warnings);
    return warnings;
}

}  // namespace drover::run
