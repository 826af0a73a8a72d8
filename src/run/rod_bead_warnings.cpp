// run/rod_bead_warnings.cpp: growth without limit, order that comes late, negative densities, densities beyond a table.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drover/physics/evaluation_cost.hpp"
#include "drover/physics/function_terms.hpp"
#include "drover/physics/linear_theory.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/warnings.hpp"
#include "run/field_health.hpp"
#include "run/growing_waves.hpp"
#include "run/judged_field.hpp"
#include "run/passed_onset.hpp"
#include "run/text_resolution.hpp"

namespace drover::run {

namespace {
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

std::vector<JudgedField> rod_bead_judged(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    const physics::UniformState& uniform = scene.model.uniform;
    const double order = order_scale(equations, scene.grid, physics::kept_degree(equations, scene.dealiasing));
    const double driving = equations.driving.at(uniform.bead_density, uniform.rod_density).value,
                 drag = equations.drag.at(uniform.bead_density, uniform.rod_density).value,
                 cubic = scene.model.driving.cubic;
    std::vector<JudgedField> fields;
    const auto add = [&](physics::FieldIndex::Value place, const char* name, int parts, const char* smoothing,
                         double scale) {
        if (const int first = equations.component(place); first >= 0)
            fields.push_back({.name = name,
                              .first = first,
                              .parts = parts,
                              .smoothing = smoothing,
                              .scale = scale,
                              .judges_transients = true});
    };
    using physics::FieldIndex;
    add(FieldIndex::bead_density, "bead_density", 1, "diffusion.beads", uniform.bead_density);
    add(FieldIndex::rod_density, "rod_density", 1, "diffusion.rods", uniform.rod_density);
    if (equations.form.velocity == physics::Velocity::dynamic)
        add(FieldIndex::bead_velocity_x, "bead_velocity", 2, "viscosity.shear",
            drag > 0.0 ? (std::abs(driving) + std::abs(cubic) * order * order) * order / drag : 0.0);
    add(FieldIndex::polar_order_x, "polar_order", 2, "elasticity.stiffness", order);
    return fields;
}

std::vector<std::string> rod_bead_warnings(const io::Scene& scene) {
    std::vector<std::string> warnings;
    add_growth(scene, warnings);
    for (const std::string& remark : physics::function_remarks(physics::CompiledModel(scene.model)))
        warnings.push_back(remark);
    return warnings;
}

void add_density_warnings(const files::ArchiveReader& archive, const io::Scene& scene,
                          std::vector<std::string>& warnings) {
    add_negative_densities(archive, scene, warnings);
    add_table_left(archive, scene, warnings);
}

void add_late_order(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings) {
    add_unsaturated(archive, scene, warnings);
}

}  // namespace drover::run
