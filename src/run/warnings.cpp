// run/warnings.cpp: unlimited growth, resolution, errors of the time step, and values that are not finite.
#include "drover/run/warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "drover/measure/fields.hpp"
#include "drover/numerics/time_method.hpp"
#include "drover/numerics/wavenumbers.hpp"
#include "drover/physics/evaluation_cost.hpp"
#include "drover/physics/function_terms.hpp"
#include "drover/physics/predictions.hpp"
#include "drover/physics/stability_rows.hpp"
#include "drover/run/field_simulation.hpp"
#include "run/field_health.hpp"
#include "run/growing_waves.hpp"
#include "run/passed_onset.hpp"
#include "run/text_resolution.hpp"

namespace drover::run {

namespace {
using physics::StructureFactor;

/// One field, and what a warning says of it.
struct JudgedField {
    std::string name;
    const char* smoothing;                          ///< the key that damps its short waves
    std::vector<double StructureFactor::*> powers;  ///< of its components
    double scale = 0.0;                             ///< its size where nonlinear terms matter; 0: its own
};

/// The recorded values of a scalar observable; empty in archives without it.
std::vector<double> series_of(const files::ArchiveReader& archive, const std::string& name) {
    const std::string dataset = std::string(field_samples_group) + "/" + name;
    return archive.has(dataset) ? archive.read(dataset).values : std::vector<double>();
}

/// The polar order at which the products in its equation compare with the linear terms; at most complete order.
double order_scale(const physics::Equations& equations, const numerics::Grid& grid, int degree) {
    const physics::Model& model = equations.model;
    const double rho = model.uniform.bead_density, sigma = model.uniform.rod_density;
    double scale = equations.form.order_is_density ? sigma : 1.0;
    if (!model.text_terms.empty()) return scale;
    const double b = equations.saturation.at(rho, sigma).value, drag = equations.drag.at(rho, sigma).value;
    double rate = std::abs(equations.relaxation.at(rho, sigma).value);
    if (drag > 0.0)
        rate += std::abs(equations.weathercock.at(rho, sigma).value * equations.driving.at(rho, sigma).value) / drag;
    if (b > 0.0 && rate > 0.0) scale = std::min(scale, std::sqrt(rate / b));
    const double advection =
        std::abs(model.advection.strength) + std::abs(model.advection.divergence) + std::abs(model.advection.gradient);
    const double largest_q = 2.0 * std::numbers::pi / (degree + 1) * std::max(grid.nx / grid.lx, grid.ny / grid.ly);
    if (advection > 0.0 && model.elasticity.stiffness > 0.0)
        scale = std::min(scale, model.elasticity.stiffness * largest_q / advection);
    return scale;
}

std::vector<JudgedField> judged_fields(const physics::Equations& equations, const numerics::Grid& grid, int degree) {
    const physics::Form& form = equations.form;
    const physics::UniformState& uniform = equations.model.uniform;
    const double order = order_scale(equations, grid, degree);
    const double driving = equations.driving.at(uniform.bead_density, uniform.rod_density).value,
                 drag = equations.drag.at(uniform.bead_density, uniform.rod_density).value,
                 cubic = equations.model.driving.cubic;
    using Part = StructureFactor;
    std::vector<JudgedField> fields;
    if (form.bead_density >= 0)
        fields.push_back({"bead_density", "diffusion.beads", {&Part::beads}, uniform.bead_density});
    if (form.rod_density >= 0) fields.push_back({"rod_density", "diffusion.rods", {&Part::rods}, uniform.rod_density});
    if (form.bead_velocity >= 0)
        fields.push_back({"bead_velocity",
                          "viscosity.shear",
                          {&Part::velocity_along, &Part::velocity_across},
                          drag > 0.0 ? (std::abs(driving) + std::abs(cubic) * order * order) * order / drag : 0.0});
    fields.push_back({"polar_order", "elasticity.stiffness", {&Part::order_along, &Part::order_across}, order});
    return fields;
}

/// The shortest waves of the grid by linear theory about the state of the run, or about the isotropic state where there
/// is no such theory; modes that grow have no powers.
struct TailTheory {
    std::vector<double> weights;          ///< numbers of modes
    std::vector<StructureFactor> powers;  ///< of each of them
    double area = 1.0;
};

/// The mean order of some samples of the second half of a run.
std::vector<Eigen::Vector2d> late_orders(const files::ArchiveReader& archive) {
    const std::vector<double> x = series_of(archive, "polar_order_mean_x"),
                              y = series_of(archive, "polar_order_mean_y");
    constexpr std::size_t most = 64;
    const std::size_t count = std::min(x.size(), y.size()), stride = std::max<std::size_t>(1, count / 2 / most);
    std::vector<Eigen::Vector2d> orders;
    for (std::size_t i = count / 2; i < count; i += stride) orders.emplace_back(x[i], y[i]);
    return orders;
}

TailTheory tail_theory(const numerics::System& system, const physics::Equations& equations, const io::Scene& scene,
                       const std::vector<Eigen::Vector2d>& orders) {
    TailTheory theory{.weights = {}, .powers = {}, .area = numerics::area(system.grid)};
    if (!system.noise) return theory;
    constexpr std::size_t max_points = std::size_t{256} * 256;  // beyond, it takes longer than all else
    if (numerics::points(system.grid) <= max_points) {
        Threads one(1);
        const std::vector<StructureFactor> modes =
            physics::predicted_structure(equations, system.grid, scene.dealiasing, orders, one).modes;
        const std::size_t width = numerics::columns(system.grid);
        for (std::size_t m = 0; m < modes.size(); ++m)
            if (numerics::is_kept(system.grid, system.degree, m % width, m / width) &&
                measure::is_in_tail(system.grid, system.degree, m % width, m / width)) {
                theory.weights.push_back(numerics::mode_weight(system.grid, m % width));
                theory.powers.push_back(modes[m]);
            }
        if (!modes.empty()) return theory;
    }
    const physics::Form& form = equations.form;
    const numerics::DistinctWavenumbers wavenumbers = numerics::distinct_wavenumbers(system.grid, system.degree);
    std::vector<double> weight(wavenumbers.q.size());
    const std::size_t width = numerics::columns(system.grid);
    for (std::size_t m = 0; m < wavenumbers.of_mode.size(); ++m)
        if (const std::int32_t n = wavenumbers.of_mode[m];
            n >= 0 && measure::is_in_tail(system.grid, system.degree, m % width, m / width))
            weight[static_cast<std::size_t>(n)] += numerics::mode_weight(system.grid, m % width);
    for (std::size_t n = 0; n < weight.size(); ++n) {
        if (weight[n] == 0.0) continue;
        try {
            theory.powers.push_back(physics::structure_factor(system, form, wavenumbers.q[n]));
            theory.weights.push_back(weight[n]);
        } catch (const Error&) {
        }
    }
    return theory;
}

/// Variance that the noise maintains in the tail of a field.
double predicted_tail(const TailTheory& theory, const JudgedField& field) {
    double sum = 0.0;
    for (std::size_t n = 0; n < theory.weights.size(); ++n)
        for (const auto part : field.powers) sum += theory.weights[n] * theory.powers[n].*part;
    return sum / theory.area;
}

/// The tail of one field at its worst.
struct Tail {
    double fraction = 0.0;  ///< of the variance of the field
    double time = 0.0;
};

/// The largest tail of the samples that count.  Those are samples whose tail the run has built up, not those in which
/// short waves of the start still decay, and whose tail is larger than `least` [unit of the field, squared]: a
/// field that is still or by now negligible needs no resolution.
Tail worst_tail(const std::vector<double>& times, const std::vector<double>& tails,
                const std::vector<double>& variances, double least) {
    Tail worst;
    for (std::size_t i = 1; i < tails.size(); ++i) {
        const double power = tails[i] * variances[i];
        const bool is_late = times[i] >= 0.5 * times.back(), is_built_up = power > 2.0 * tails[0] * variances[0];
        if ((is_late || is_built_up) && power > least && tails[i] > worst.fraction)
            worst = {.fraction = tails[i], .time = times[i]};
    }
    return worst;
}

/// Points that would resolve a field with this tail.  Steepening fronts on 64 to 512 points: the tail falls as 1/N at
/// first, then at least as 1/N^2, and exponentially once the width of the front is resolved.
int points_that_resolve(int points, double tail) {
    const double excess = tail / max_spectral_tail, factor = std::min({excess, 2.0 * std::sqrt(excess), 32.0});
    int result = 2 * points;
    while (result < factor * points) result *= 2;
    return result;
}

void add_resolution(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings) {
    const physics::Equations equations(scene.model);
    if (!physics::is_nonlinear(equations)) return;
    const numerics::System system = physics::linear_system(scene.model, scene.grid, scene.dealiasing);
    const std::vector<double> times = series_of(archive, "time");
    std::optional<TailTheory> theory;  // takes longer than all else
    for (const JudgedField& field : judged_fields(equations, scene.grid, system.degree)) {
        const std::vector<double> tails = series_of(archive, "spectral_tail_" + field.name),
                                  variances = series_of(archive, "variance_" + field.name);
        if (tails.size() < 2 || variances.size() != tails.size() || times.size() != tails.size()) continue;
        const double own = *std::max_element(variances.begin(), variances.end());
        constexpr double rounding = 1e-20;  // mm-4, of a density whose mean is 0: nothing is there
        if (field.scale == 0.0 && own < rounding) continue;
        const double size = field.scale > 0.0 ? field.scale * field.scale : own;
        const double least = max_spectral_tail * std::max(max_spectral_tail * size, own);
        Tail worst = worst_tail(times, tails, variances, least);
        if (worst.fraction <= max_spectral_tail) continue;
        if (!theory) theory = tail_theory(system, equations, scene, late_orders(archive));
        const double linear = predicted_tail(*theory, field);
        worst = worst_tail(times, tails, variances, std::max(least, max_tail_over_linear * linear));
        if (worst.fraction <= max_spectral_tail) continue;
        numerics::Grid finer = scene.grid;
        finer.nx = points_that_resolve(finer.nx, worst.fraction);
        if (finer.ny > 1) finer.ny = points_that_resolve(finer.ny, worst.fraction);
        warnings.push_back(text(
            "the grid does not resolve {} with {}: {:.2g} of its variance is in the shortest waves of the grid at "
            "t = {:.6g} s (spectral_tail_{}); expected less than {}: choose {}, or a larger {}; a step that is too "
            "long has the same effect: try time.dt = {}",
            field.name, grid_keys(scene.grid), worst.fraction, worst.time, field.name, max_spectral_tail,
            grid_keys(finer), field.smoothing, 0.5 * scene.time.dt));
    }
}

void add_not_finite(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings) {
    const measure::FieldSetting setting = measure::make_field_setting(scene.grid, physics::form(scene.model), 1);
    std::vector<std::string> names;
    for (const auto& row : measure::field_observables(setting)) {
        // Others may be undefined, such as the alignment with a flow at rest.
        const bool is_of_field = row.name.starts_with("variance_") || row.name.starts_with("spectral_tail_");
        if (!is_of_field) continue;
        const std::vector<double> values = series_of(archive, row.name);
        if (std::any_of(values.begin(), values.end(), [](double value) { return !std::isfinite(value); }))
            names.push_back(row.name);
    }
    if (names.empty()) return;
    warnings.push_back(
        text("not finite in at least one sample: {}; the run diverged: choose a smaller time.dt than {}, or add a "
             "term that limits growth, such as relaxation.saturation",
             joined(names), scene.time.dt));
}

/// Largest growth rate of a uniform state, at q = 0.
physics::FastestGrowth uniform_growth(const numerics::System& system) {
    physics::FastestGrowth growth{.rate = -std::numeric_limits<double>::infinity()};
    for (const numerics::Complex rate : numerics::eigenvalues(system.linear(0.0).even))
        growth.rate = std::max(growth.rate, rate.real());
    return growth;
}

/// Growth without limit.  Of a linear model that of any mode; else that of the uniform order, which only a saturation
/// or a term written as text can stop.
void add_growth(const io::Scene& scene, std::vector<std::string>& warnings) {
    const physics::Equations equations(scene.model);
    if (equations.saturation.is_active() || !scene.model.text_terms.empty()) return;
    const numerics::System system = physics::linear_system(scene.model, scene.grid, scene.dealiasing);
    const physics::FastestGrowth growth =
        physics::is_nonlinear(equations) ? uniform_growth(system) : physics::fastest_growth(system);
    const double most = std::log(max_field_size);
    if (growth.rate * scene.time.end <= most) return;
    warnings.push_back(
        text("a mode grows at {:.4g} /s at |q| = {:.3g} /mm, by a factor e^{:.3g} in this run, and no term stops it "
             "(relaxation.saturation = 0): give relaxation.saturation > 0, or choose time.end = {:.2g} or less",
             growth.rate, growth.q, growth.rate * scene.time.end, most / growth.rate));
}

/// The rate at which a size grows at the end of a run as an exponential or faster; 0: it does not.
double late_growth(const std::vector<double>& times, const std::vector<double>& sizes) {
    constexpr std::size_t min_samples = 6;
    constexpr double least = 0.1;  // of the logarithm, in the last third of the run
    const std::size_t count = std::min(times.size(), sizes.size());
    if (count < min_samples) return 0.0;
    const std::size_t first = count / 3, second = 2 * count / 3;
    if (!(sizes[first] > 0.0 && sizes[second] > 0.0)) return 0.0;
    const double before = std::log(sizes[second] / sizes[first]), last = std::log(sizes[count - 1] / sizes[second]);
    // A size that grows in proportion to time has 0.6 of it.
    return last > least && last >= 0.8 * before ? last / (times[count - 1] - times[second]) : 0.0;
}

/// Whether a text changes the growth of the order in time.
bool has_ramp(const physics::Model& model) {
    for (const physics::TextTerm& term : model.text_terms)
        for (const physics::WrittenExpression& one : term.value)
            if (mentions(one.text, {"t"}) && mentions(one.text, {"order_x", "order_y"})) return true;
    return false;
}

/// Without noise order grows from what the start or another run has left, as on a ramp, or not at all: such a run ends
/// before its state.
void add_unsaturated(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings) {
    const physics::Equations equations(scene.model);
    if (physics::has_noise(scene.model.noise) || !equations.saturation.is_active()) return;
    // Texts may be ramps in time, and may bound the order by themselves.
    const bool has_texts = !scene.model.text_terms.empty();
    if (!has_ramp(scene.model) && scene.initial.kind != "file" && scene.initial.kind != "uniform") return;
    const std::vector<double> times = series_of(archive, "time"), x = series_of(archive, "polar_order_mean_x"),
                              y = series_of(archive, "polar_order_mean_y"),
                              variances = series_of(archive, "variance_polar_order");
    if (x.empty() || y.size() != x.size() || variances.size() != x.size()) return;
    std::vector<double> orders;
    for (std::size_t i = 0; i < x.size(); ++i) orders.push_back(std::sqrt(x[i] * x[i] + y[i] * y[i] + variances[i]));
    const numerics::System system = physics::linear_system(scene.model, scene.grid, scene.dealiasing);
    const double order = orders.back(), size = order_scale(equations, scene.grid, system.degree);
    const bool is_measured = has_texts && order > 0.0;
    const double rate = is_measured ? late_growth(times, orders) : physics::fastest_growth(system).rate;
    constexpr double far = 0.1;
    if (is_measured && rate == 0.0 && has_ramp(scene.model)) {
        const PassedOnset onset = passed_onset(scene);
        constexpr double least = 0.5;  // the logarithm of a factor
        if (onset.exponent > least && order < far * onset.order)
            warnings.push_back(
                text("the run ends soon after its onset: the order is {:.2g} at the end, far below the {:.2g} at which "
                     "it saturates; since the onset it can have grown by a factor of {:.2g}, at {:.3g} /s at the end: "
                     "choose a longer run, a slower change in time, a larger initial.amplitude, or noise",
                     order, onset.order, std::exp(onset.exponent), onset.rate));
        return;
    }
    if (!(is_measured ? rate > 0.0 : rate * scene.time.end > 1.0) || !(order < far * size)) return;
    if (order == 0.0)
        warnings.push_back(
            text("the isotropic state is unstable (a mode grows at {:.3g} /s), and without noise nothing perturbs it: "
                 "the run stays there; give initial.kind = \"random\", or noise",
                 rate));
    else
        warnings.push_back(
            text("the order is {:.2g} at the end, far below {}, and it grows at {:.3g} /s "
                 "from what the start contains: without noise the run shows its state late; choose {}, "
                 "a larger initial.amplitude, or noise",
                 order, has_texts ? std::string("complete order") : text("the {:.2g} at which it saturates", size),
                 rate,
                 has_texts ? std::string("a longer run, or a slower change in time")
                           : text("time.end = {:.3g}", scene.time.end + 1.5 * std::log(size / order) / rate)));
}

/// Samples below a limit (or above it, with the sign -1), and the worst of them.
struct Excess {
    std::size_t samples = 0;
    double worst = 0.0, time = 0.0;
};
Excess samples_below(const files::ArchiveReader& archive, const std::string& observable, double limit,
                     double sign = 1.0) {
    const std::vector<double> values = series_of(archive, observable), times = series_of(archive, "time");
    Excess excess;
    for (std::size_t i = 0; i < std::min(values.size(), times.size()); ++i) {
        if (!(sign * values[i] < sign * limit)) continue;
        if (++excess.samples == 1 || sign * values[i] < sign * excess.worst)
            excess = {.samples = excess.samples, .worst = values[i], .time = times[i]};
    }
    return excess;
}

/// Whether the scene has some waves on a grid, and all that grow.
bool has_waves(const io::Scene& scene, const numerics::Grid& grid) {
    const numerics::System system = physics::linear_system(scene.model, grid, scene.dealiasing);
    constexpr std::size_t fewest = 4;  // along an axis
    return (grid.nx == scene.grid.nx || numerics::is_kept(grid, system.degree, fewest, 0)) &&
           (grid.ny == scene.grid.ny || numerics::is_kept(grid, system.degree, 0, fewest)) &&
           growing_waves_warning(system).empty();
}

/// Negative densities, except where the model is linear in the density and its noise allows them, and where the model
/// stops at them.
void add_negative_densities(const files::ArchiveReader& archive, const io::Scene& scene,
                            std::vector<std::string>& warnings) {
    const physics::Form form = physics::form(scene.model);
    const bool noise = physics::has_noise(scene.model.noise);
    const bool rods_are_linear = form.order_is_density && noise;
    const bool beads_are_linear = form.velocity == physics::Velocity::absent && noise;
    const auto add = [&](const std::string& what, int component, bool is_linear, double mean, double its_noise) {
        if (component < 0 || is_linear) return;
        // An edge, such as that of a vacuum, rings by less than a hundredth of the density beside it.
        const std::vector<double> highest = series_of(archive, "max_" + what + "_density");
        const double scale = highest.empty() ? mean : *std::max_element(highest.begin(), highest.end());
        const Excess negative = samples_below(archive, "min_" + what + "_density", -0.01 * scale);
        if (negative.samples == 0) return;
        const double in_cell = mean * numerics::area(scene.grid) / static_cast<double>(numerics::points(scene.grid));
        std::string remedy = text("choose a larger diffusion.{0}s, a smaller time.dt or a finer grid", what);
        if (noise) {
            // Relative shot noise of 1/4 or less in a cell: zero is four standard deviations away.
            constexpr double min_in_cell = 16.0;
            const bool one_row = scene.grid.ny == 1;
            const double excess = std::max(min_in_cell / in_cell, 4.0), factor = one_row ? excess : std::sqrt(excess);
            const auto even = [&](int points) { return std::max(4, 2 * static_cast<int>(points / factor / 2.0)); };
            numerics::Grid coarser = scene.grid;
            coarser.nx = even(coarser.nx);
            if (!one_row) coarser.ny = even(coarser.ny);
            remedy = text("a cell of the grid holds {:.2g} {}s", in_cell, what);
            remedy += has_waves(scene, coarser)
                          ? text(": choose larger cells, {}", grid_keys(coarser))
                          : text(
                                ", and no grid with waves has cells that hold enough: choose a larger "
                                "uniform.{}_density",
                                what);
            if (its_noise > 0.0) remedy += text(", or noise.{}s below {:.2g}", what, its_noise / 4.0);
        }
        if (what == "rod")
            remedy += ", or current.kind = \"order\", which is linear in the density and allows negative ones";
        warnings.push_back(
            text("the {} density is negative in {} samples, {:.3g} mm-2 at t = {:.6g} s, and the equations "
                 "are not linear in it (min_{}_density); expected >= 0: {}",
                 what, negative.samples, negative.worst, negative.time, what, remedy));
    };
    add("rod", form.rod_density, rods_are_linear, scene.model.uniform.rod_density, scene.model.noise.rods);
    add("bead", form.bead_density, beads_are_linear, scene.model.uniform.bead_density, scene.model.noise.beads);
}

/// Densities beyond a table whose outermost values are held there.
void add_table_left(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings) {
    const physics::TableData& table = scene.model.table;
    if (!table.has_values() || table.outside != "hold") return;
    for (const auto& [what, nodes] : {std::pair{"bead", &table.bead_density}, std::pair{"rod", &table.rod_density}}) {
        if (nodes->size() < 2) continue;
        const Excess below = samples_below(archive, text("min_{}_density", what), nodes->front()),
                     above = samples_below(archive, text("max_{}_density", what), nodes->back(), -1.0);
        for (const Excess& excess : {below, above})
            if (excess.samples > 0)
                warnings.push_back(text(
                    "the {} density left the table of coefficients in {} samples, {:.4g} mm-2 at t = {:.6g} s; its "
                    "outermost values were held there (table.outside = \"hold\"): give a table beyond {:.4g} to "
                    "{:.4g} mm-2",
                    what, excess.samples, excess.worst, excess.time, nodes->front(), nodes->back()));
    }
}
}  // namespace

void add_step_error(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings) {
    const std::vector<double> errors = series_of(archive, "step_error"), times = series_of(archive, "time");
    if (errors.empty() || times.size() != errors.size() || scene.time.max_error == 0.0) return;
    const auto worst = std::max_element(errors.begin(), errors.end());
    // A step that was chosen for means need not follow the noise path more closely than this.
    constexpr double decoupled = 0.3;
    const double allowed = std::max(scene.time.max_error, scene.time.chosen == "means" ? decoupled : 0.0);
    if (*worst <= allowed) return;
    if (scene.time.tolerance > 0.0) {  // dt may be no more than an interval of outputs
        warnings.push_back(
            text("the steps of {} are too inaccurate: their estimated error is {:.2g} of a field's fluctuation at "
                 "t = {:.6g} s (step_error); expected at most time.max_error = {}: choose time.tolerance = {:.1g}",
                 scene.time.stepper, *worst, times[static_cast<std::size_t>(worst - errors.begin())],
                 scene.time.max_error,
                 std::max(1e-3 * scene.time.tolerance, 0.5 * scene.time.tolerance * scene.time.max_error / *worst)));
        return;
    }
    // With noise the methods have order 1.5 to 2.
    const double order = io::has_noise(scene) ? 1.5 : numerics::time_method(scene.time.stepper).order;
    constexpr double max_halvings = 20.0;  // of an error that is infinite
    const double halvings = std::min(max_halvings, std::ceil(std::log2(*worst / scene.time.max_error) / order));
    warnings.push_back(
        text("time.dt = {} is too long: its estimated error is {:.2g} of a field's fluctuation at t = {:.6g} s "
             "(step_error){}; expected "
             "at most time.max_error = {}: choose time.dt = {}{}{}",
             scene.time.dt, *worst, times[static_cast<std::size_t>(worst - errors.begin())],
             *worst >= 1.0 ? ", so the fields are unrelated to the exact ones, and at best their means are right" : "",
             scene.time.max_error, scene.time.dt * std::exp2(-halvings),
             order < 4.0 && scene.time.stepper != "etdrk4-krogstad" ? ", or time.stepper = \"etdrk4-krogstad\"" : "",
             scene.time.chosen == "means" ? " if the fields matter; it was chosen for means, whose column is step"
                                          : ""));
}

std::vector<std::string> field_scene_warnings(const io::Scene& scene) {
    std::vector<std::string> warnings =
        physics::initial_warnings(scene.initial, scene.model, scene.grid, scene.dealiasing);
    add_growth(scene, warnings);
    for (std::string& warning : text_resolution_warnings(scene)) warnings.push_back(std::move(warning));
    for (const std::string& remark : physics::function_remarks(physics::CompiledModel(scene.model)))
        warnings.push_back(remark);
    return warnings;
}
std::vector<std::string> field_warnings(const files::ArchiveReader& archive, const io::Scene& scene) {
    std::vector<std::string> warnings = field_scene_warnings(scene);
    add_not_finite(archive, scene, warnings);
    add_resolution(archive, scene, warnings);
    add_negative_densities(archive, scene, warnings);
    add_table_left(archive, scene, warnings);
    add_step_error(archive, scene, warnings);
    add_unsaturated(archive, scene, warnings);
    return warnings;
}

}  // namespace drover::run
