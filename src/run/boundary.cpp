// run/boundary.cpp: phase boundaries as a result.
#include "drover/run/boundary.hpp"

#include "drover/base/log.hpp"
#include "drover/physics/regimes.hpp"
#include "run/binodal_lines.hpp"
#include "run/boundary_plan.hpp"
#include "run/boundary_records.hpp"
#include "run/model_boundary.hpp"

namespace drover::run {

namespace {
/// A unit of the schema as UDUNITS text: [p] is the unit of the order.
std::string udunits(std::string unit, const physics::Form& form) {
    const std::string order = form.order_is_density ? "(mm^-2)" : "1";
    for (std::size_t at = unit.find("[p]"); at != std::string::npos; at = unit.find("[p]")) unit.replace(at, 3, order);
    return unit;
}

DescribedAxis described(const physics::PlaneAxis& axis, const physics::Form& form) {
    return {
        .name = axis.name, .unit = axis.unit, .udunits = udunits(axis.unit, form), .from = axis.from, .to = axis.to};
}

files::ResultTable regime_map(const physics::Plane& plane, const DescribedPlane& described, int side,
                              Threads& threads) {
    const MapPoints map = map_points(described, side);
    std::vector<double> codes, relaxation;
    for (const physics::RegimePoint& point : physics::regimes(plane, map.points, threads)) {
        codes.push_back(static_cast<double>(point.regime));
        relaxation.push_back(point.effective_relaxation);
    }
    const std::vector<std::string> axes{"map_y", "map_x"};
    return {.group = {},
            .axes = map.axes,
            .quantities = {{"regime", "1", physics::regime_legend(), axes},
                           {"effective_relaxation", "s-1", "abar = a - lambda alpha/Gamma", axes}},
            .values = {codes, relaxation}};
}

/// Of a table at one point, in a plane of area fractions.
void warn_of_fixed_coefficients(const io::Scene& scene, const physics::Plane& plane) {
    const auto is_fraction = [](const physics::PlaneAxis& axis) { return physics::find_area_fraction(axis.name); };
    const io::CalibratedPlan& calibrated = scene.calibrated;
    if (calibrated.filled.empty() || calibrated.coefficients == "local" ||
        !(is_fraction(plane.x) || is_fraction(plane.y)))
        return;
    log_warning(
        "area fractions of the plane change the densities alone: all coefficients stay those of {} at "
        "calibrated.bead_area_fraction = {} and calibrated.rod_area_fraction = {}; for those at each point give "
        "calibrated.coefficients = \"local\"",
        calibrated.table, calibrated.bead_area_fraction, calibrated.rod_area_fraction);
}

/// The model with all its uncertain numbers drawn within their errors; none if there are no such numbers.
std::vector<physics::Model> draws_of(const io::Scene& scene, const PlannedBoundary& planned) {
    const bool has_errors = !planned.uncertain.empty() || !scene.calibrated.filled.empty();
    if (!has_errors || scene.boundary.draws == 0) return {};
    std::vector<physics::Model> models = io::drawn_models(scene, scene.boundary.draws);
    physics::draw_errors(planned.uncertain, models);
    if (models.empty())
        log_warning("none of {} draws of the numbers with errors is a valid model: the lines have no error bands",
                    scene.boundary.draws);
    return models;
}

DescribedLines lines_of(const std::string& name, const std::string& convention) {
    return {.heading = text("{} ({} convention of lambda)", name, convention),
            .names = {{.name = "limit",
                       .unit = "",
                       .meaning = "the instability that begins, or binodal: densities of phases that coexist",
                       .value = name,
                       .choices = line_names(),
                       .shown = {.text = false}},
                      {.name = "convention",
                       .unit = "",
                       .meaning = "convention of lambda",
                       .value = convention,
                       .choices = {"mean", "single-rod"},
                       .shown = {.text = false}}},
            .shows_angles = name == physics::limit_name(physics::Limit::oblique)};
}
}  // namespace

void check_boundary(const io::Scene& scene) {
    // An axis that is missing may be given with the command.
    if (scene.boundary.x.empty() || scene.boundary.y.empty()) return;
    if (scene.kind == io::SceneKind::model) return check_model_boundary(scene);
    const PlannedBoundary planned = plan_boundary(scene);
    if (planned.has_binodal) check_binodal_plane(scene, planned.plane);
}

Result make_boundary(const io::Scene& scene, Threads& threads, const BoundaryWork& work) {
    if (scene.kind == io::SceneKind::model) return make_model_boundary(scene, threads, work);
    const ComputeAll compute = compute_of(work, threads);
    PlannedBoundary planned = plan_boundary(scene);
    physics::Plane& plane = planned.plane;
    warn_of_fixed_coefficients(scene, plane);
    const physics::Form form = physics::form(scene.model);
    std::vector<physics::Model> draws = draws_of(scene, planned);
    const DescribedPlane described_plane{.x = described(plane.x, form),
                                         .y = described(plane.y, form),
                                         .draws = static_cast<std::size_t>(draws.empty() ? 0 : scene.boundary.draws),
                                         .cells = scene.boundary.cells};
    const numerics::ContourOptions options{.cells = scene.boundary.cells, .chord = scene.boundary.chord};
    List traced{.name = "traced"};
    BandMaps bands(described_plane);
    bool complete = true;
    for (const std::string& convention : planned.conventions) {
        plane.model.weathercock.convention = convention;
        for (physics::Model& one : draws) one.weathercock.convention = convention;
        for (const physics::Limit limit : planned.limits) {
            const physics::Boundary boundary = physics::trace_boundary(plane, limit, draws, options, compute);
            complete = complete && boundary.complete;
            const DescribedLines described_lines = lines_of(physics::limit_name(limit), convention);
            traced.rows.push_back(traced_record(described_plane, described_lines, boundary));
            bands.add(described_lines, boundary);
        }
        if (!planned.has_binodal || work.lines_alone) continue;
        const BinodalLines binodal = trace_binodal_lines(scene, plane, threads);
        Record record = traced_record(described_plane, lines_of(binodal_name, convention), binodal.boundary);
        record.footer = binodal.ends;
        traced.rows.push_back(std::move(record));
    }
    Result result{.root = plane_record(described_plane, complete, std::move(traced)),
                  .attributes = {{"boundary_x", plane.x.name}, {"boundary_y", plane.y.name}}};
    bands.add_to(result.root);
    plane.model.weathercock.convention = planned.conventions.front();
    if (scene.boundary.map > 0 && !work.lines_alone)
        result.root.parts.push_back({"map",
                                     {.group = "/map",
                                      .maps = regime_map(plane, described_plane, scene.boundary.map, threads),
                                      .shown = {.text = false}}});
    return result;
}

}  // namespace drover::run
