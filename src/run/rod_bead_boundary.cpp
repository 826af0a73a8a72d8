// run/rod_bead_boundary.cpp: limits of stability, binodals and regimes of rods and beads over a plane.
#include <array>

#include "drover/base/log.hpp"
#include "drover/physics/regimes.hpp"
#include "run/boundary_problem.hpp"

namespace drover::run {

namespace {
using physics::Limit;

physics::PlaneAxis axis_in(const io::Scene& scene, const DescribedAxis& axis) {
    if (const physics::AreaFraction* fraction = physics::find_area_fraction(axis.name))
        return physics::area_fraction_axis(*fraction, scene.model.uniform.*fraction->area, axis.from, axis.to);
    return {.name = axis.name,
            .unit = axis.unit,
            .from = axis.from,
            .to = axis.to,
            .set = [in = io::model_number(axis.name, {}, scene.model).in](physics::Model& model,
                                                                          double held) { in(model) = held; },
            .is_density = physics::density_axis(axis.name) != physics::DensityAxis::none};
}

/// Of a table at one point, in a plane of area fractions.
void warn_of_fixed_coefficients(const io::Scene& scene, const PlannedBoundary& planned) {
    const io::CalibratedPlan& calibrated = scene.calibrated;
    if (calibrated.filled.empty() || calibrated.coefficients == "local" ||
        !(physics::find_area_fraction(planned.x.name) || physics::find_area_fraction(planned.y.name)))
        return;
    log_warning(
        "area fractions of the plane change the densities alone: all coefficients stay those of {} at "
        "calibrated.bead_area_fraction = {} and calibrated.rod_area_fraction = {}; for those at each point give "
        "calibrated.coefficients = \"local\"",
        calibrated.table, calibrated.bead_area_fraction, calibrated.rod_area_fraction);
}

/// The model with all its uncertain numbers drawn within their errors; none if there are no such numbers.
std::vector<physics::Model> draws_of(const io::Scene& scene, const PlannedBoundary& planned) {
    std::vector<physics::Uncertain> uncertain = physics::table_errors(scene.model);
    for (const auto& [key, error] : planned.errors)
        uncertain.push_back(
            {.name = key,
             .error = error,
             .add = [in = io::model_number(key, {}, scene.model).in](physics::Model& model, double change) {
                 in(model) += change;
             }});
    const bool has_errors = !uncertain.empty() || !scene.calibrated.filled.empty();
    if (!has_errors || scene.boundary.draws == 0) return {};
    std::vector<physics::Model> models = io::drawn_models(scene, scene.boundary.draws);
    physics::draw_errors(uncertain, models);
    if (models.empty())
        log_warning("none of {} draws of the numbers with errors is a valid model: the lines have no error bands",
                    scene.boundary.draws);
    return models;
}

DescribedLines described_limit(const std::string& name, const std::string& convention) {
    return {.heading = text("{} ({} convention of lambda)", name, convention),
            .names = {{.name = "limit",
                       .unit = "",
                       .meaning = "the instability that begins, or binodal: densities of phases that coexist",
                       .value = name,
                       .choices = line_names(io::SceneKind::fields),
                       .shown = {.text = false}},
                      {.name = "convention",
                       .unit = "",
                       .meaning = "convention of lambda",
                       .value = convention,
                       .choices = {"mean", "single-rod"},
                       .shown = {.text = false}}},
            .shows_angles = name == physics::limit_name(Limit::oblique)};
}

/// The regime at a point, and abar.
std::function<std::vector<double>(const numerics::PlanePoint&)> regime_at(const physics::Plane& plane) {
    const std::array over{physics::margins_over(plane, Limit::onset).at,
                          physics::margins_over(plane, Limit::phase_separation).at,
                          physics::margins_over(plane, Limit::banding).at,
                          physics::margins_over(plane, Limit::oblique).at};
    return [over](const numerics::PlanePoint& point) -> std::vector<double> {
        std::array<double, over.size()> margins{};
        for (std::size_t n = 0; n < over.size(); ++n) margins[n] = over[n](point).value;
        return {static_cast<double>(physics::regime_of(margins[0], margins[1], margins[2], margins[3])), margins[0]};
    };
}
}  // namespace

BoundaryProblem rod_bead_boundary(const io::Scene& scene, const PlannedBoundary& planned) {
    warn_of_fixed_coefficients(scene, planned);
    const std::vector<physics::Model> draws = draws_of(scene, planned);
    BoundaryProblem problem{.draws = static_cast<std::size_t>(draws.empty() ? 0 : scene.boundary.draws)};
    physics::Plane plane{.model = scene.model, .x = axis_in(scene, planned.x), .y = axis_in(scene, planned.y)};
    for (const std::string& convention : planned.conventions) {
        plane.model.weathercock.convention = convention;
        for (const std::string& name : planned.lines) {
            PlaneLines lines{.described = described_limit(name, convention)};
            if (name == binodal_name)
                lines.binodals = [scene, plane](Threads& threads) {
                    return trace_binodal_lines(scene, plane, threads);
                };
            else
                lines.margins = [plane, draws, convention, limit = physics::limit_of(name)] {
                    std::vector<physics::Model> drawn = draws;
                    for (physics::Model& one : drawn) one.weathercock.convention = convention;
                    return physics::margins_over(plane, limit, drawn);
                };
            problem.lines.push_back(std::move(lines));
        }
    }
    if (scene.boundary.map == 0) return problem;
    const std::vector<std::string> axes{"map_y", "map_x"};
    problem.map = {{"regime", "1", physics::regime_legend(), axes},
                   {"effective_relaxation", "s-1", "abar = a - lambda alpha/Gamma", axes}};
    plane.model.weathercock.convention = planned.conventions.front();
    problem.map_at = regime_at(plane);
    return problem;
}

}  // namespace drover::run
