// run/warnings/scene_warnings.cpp: what is known of a run of fields before it.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "base/constants.hpp"
#include "calibrate/slow_order.hpp"
#include "io/declared_model.hpp"
#include "model/start.hpp"
#include "numerics/solvers/fastest_growth.hpp"
#include "physics/program_functions.hpp"
#include "physics/written_model.hpp"
#include "run/fields/field_health.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// Whether uniform deviations of one size from the references obey linear equations: tried at two of them and their
/// sum.  Nothing where values are not finite.
std::optional<bool> is_linear_at(const model::Equations& equations, double size) {
    const model::UniformState rest = equations.reference();
    model::UniformState one = rest, other = rest, both = rest;
    std::size_t at = 0;
    for (const model::Field& field : equations.model().fields)
        for (int k = 0; k < model::components(field); ++k, ++at) {
            if (field.conserved) continue;
            one[at] += size * std::cos(static_cast<double>(at));
            other[at] += size * std::cos(static_cast<double>(2 * at + 1));
            both[at] += one[at] + other[at] - 2.0 * rest[at];
        }
    const Eigen::ArrayXd excess = equations.uniform_rates(both) + equations.uniform_rates(rest) -
                                  equations.uniform_rates(one) - equations.uniform_rates(other),
                         allowed = 1e-9 * equations.uniform_rate_sizes(both);
    if (!excess.allFinite() || !allowed.allFinite()) return std::nullopt;
    return (excess.abs() <= allowed).all();
}

/// Whether uniform deviations from the references with the same conserved means obey linear equations, so that nothing
/// limits their growth.  At which size products count depends on the units: all are tried whose cubes are doubles, and
/// none of small ones, since what counts there alone grows too slowly to limit anything.
bool is_linear_when_uniform(const model::Equations& equations) {
    bool is_known = false;
    for (int decade = 3; decade <= 99; decade += 3) {
        const std::optional<bool> is_linear = is_linear_at(equations, std::pow(10.0, decade));
        if (is_linear == false) return false;
        is_known = is_known || is_linear.has_value();
    }
    return is_known;
}

/// Growth of linear equations, or of uniform deviations that obey such.
void add_growth(const io::Scene& scene, const model::Equations& equations, const numerics::System& system,
                std::vector<std::string>& warnings) {
    numerics::FastestGrowth growth{.rate = -infinite};
    if (!equations.has_nonlinear_part()) growth = numerics::fastest_growth(system);
    else
        for (const numerics::Block& block : {system.linear(0.0).even, system.linear(0.0).odd})
            for (const numerics::Complex rate : numerics::eigenvalues(block))
                growth.rate = std::max(growth.rate, rate.real());
    const double max_log = std::log(max_field_size);
    if (growth.rate * scene.time.end <= max_log) return;
    if (equations.has_nonlinear_part() &&
        (calls_program(scene) || !placed_term_of(scene, equations).empty() || !is_linear_when_uniform(equations)))
        return;
    std::string limits;
    for (const model::Field& field : equations.model().fields)
        if (const std::string key = key_of_term(scene, equations, field, text("|{0}|^2 {0}", field.symbol));
            !key.empty())
            limits = text("give {} > 0", key);
    warnings.push_back(
        text("a mode grows at {} at |q| = {}, by a factor e^{:.3g} in this run, and no term stops it: "
             "{}, or choose time.end = {:.2g} or less",
             io::in_unit("{:.4g}", growth.rate, "/s", scene.units), io::in_unit("{:.3g}", growth.q, "/mm", scene.units),
             growth.rate * scene.time.end, limits.empty() ? "add a product that does" : limits, max_log / growth.rate));
}

/// Where the noise of the waves of the grid saturates the order of rods, and its counterterm is missing or too large.
void add_saturation_by_waves(const io::Scene& scene, int degree, std::vector<std::string>& warnings) {
    constexpr double max_without = 0.1, max_part = 1.0;
    const bool has_counterterm = scene.approximation.counterterm;
    if (scene.kind != io::SceneKind::fields || (scene.found.filled.empty() && !has_counterterm)) return;
    const double part = calibrate::part_of_waves(scene.model, {scene.grid, degree});
    if (!has_counterterm && part > max_without)
        warnings.push_back(text(
            "noise in the Fourier modes of this grid saturates the order, as if it decayed {:.3g} times as fast; the "
            "rods of the table show no such effect, and the order falls as the grid is refined: set "
            "approximation.counterterm = true",
            1.0 + part));
    if (has_counterterm && part > max_part)
        warnings.push_back(text(
            "approximation.counterterm subtracts {:.3g} times the decay rate of the order, so that order grows by "
            "itself: the counterterm is a first-order correction, valid only where it is small; choose a coarser grid, "
            "which has fewer modes per rod",
            part));
}
}  // namespace

bool calls_program(const io::Scene& scene) {
    return std::ranges::any_of(scene.model.text_terms, [](const auto& term) { return !term.function.empty(); });
}

bool stays_at_start(const io::Scene& scene, const model::Equations& equations) {
    return scene.initial.kind == model::StartKind::uniform && !equations.has_noise() &&
           placed_term_of(scene, equations).empty() &&
           equations.uniform_rates(equations.reference()).cwiseAbs().maxCoeff() == 0.0;
}

std::vector<std::string> field_scene_warnings(const io::Scene& scene, const model::Integrated& what) {
    const model::Equations& equations = what.equations;
    const int degree = what.kept_degree;
    std::vector<std::string> warnings = model::start_warnings(scene.initial, equations, scene.grid, degree);
    if (scene.kind == io::SceneKind::fields)
        std::ranges::move(physics::function_remarks(physics::CompiledModel(scene.model)), std::back_inserter(warnings));
    if (!physics::missing_function(scene.model).empty()) return warnings;
    add_saturation_by_waves(scene, degree, warnings);
    const numerics::System system = equations.linear_system(scene.grid, degree);
    if (!numerics::is_kept(scene.grid, degree, 1, 0) && !numerics::is_kept(scene.grid, degree, 0, 1)) {
        numerics::Grid least = scene.grid;
        least.nx = degree + 2 + degree % 2;
        if (least.ny > 1) least.ny = least.nx;
        warnings.push_back(
            text("products of degree {} leave no wave on {} by {} points: the fields are uniform; choose at least {}",
                 degree, scene.grid.nx, scene.grid.ny, grid_keys(least)));
    }
    if (const std::vector<std::string> idle = io::without_effect(scene.declared); !idle.empty())
        warnings.push_back(text("{} {} no effect: no equation has {}; use or delete {}", joined(idle),
                                idle.size() == 1 ? "has" : "have", idle.size() == 1 ? "it" : "them",
                                idle.size() == 1 ? "it" : "them"));
    if (scene.kind == io::SceneKind::model) {  // a flock is far from its references
        if (std::string cut = growing_waves_warning(equations, system, scene.units); !cut.empty())
            warnings.push_back(std::move(cut));
        if (!equations.has_finite_degree())
            warnings.emplace_back(
                "some functions of the equations are no polynomials: their aliases are not removed exactly; compare "
                "with a run on twice the points");
    }
    if (const double rate = equations.explicit_rate(scene.grid), part = rate * scene.time.dt;
        part > 1.0 && scene.time.tolerance == 0.0)
        warnings.push_back(
            text("the terms that name an axis, depend on position or time, or are explicit change the waves of the "
                 "grid at up to {}: {:.3g} in a step of time.dt = {}; expected less than 1, otherwise the run may "
                 "diverge: choose "
                 "time.dt = {:.2g}, or a coarser grid",
                 io::in_unit("{:.3g}", rate, "/s", scene.units), part, scene.time.dt, scene.time.dt / (2.0 * part)));
    add_growth(scene, equations, system, warnings);
    if (stays_at_start(scene, equations)) {
        const double rate = numerics::fastest_growth(system).rate;
        warnings.push_back(
            text("the start is uniform, stationary and without noise: nothing will change{}; choose initial.kind = "
                 "\"random\", or noise",
                 rate > 0.0 ? ", although a mode grows at " + io::in_unit("{:.3g}", rate, "/s", scene.units) : ""));
    }
    std::ranges::move(text_resolution_warnings(scene, equations.model()), std::back_inserter(warnings));
    return warnings;
}

}  // namespace drover::run
