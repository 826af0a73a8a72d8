// run/boundary.cpp: phase boundaries as a result.
#include "drover/run/boundary.hpp"

#include <cmath>
#include <numbers>

#include "drover/physics/regimes.hpp"
#include "run/binodal_lines.hpp"
#include "run/boundary_plan.hpp"

namespace drover::run {

namespace {
constexpr double degree = std::numbers::pi / 180.0;

/// What the records of lines and points need to know.
struct Described {
    const physics::Plane& plane;
    std::string unit_x, unit_y;  ///< UDUNITS text
    bool has_errors = false;
};

/// A unit of the schema as UDUNITS text: [p] is the unit of the order.
std::string udunits(std::string unit, const physics::Form& form) {
    const std::string order = form.order_is_density ? "(mm^-2)" : "1";
    for (std::size_t at = unit.find("[p]"); at != std::string::npos; at = unit.find("[p]")) unit.replace(at, 3, order);
    return unit;
}

struct Shift {
    double along_x = 0.0, along_y = 0.0;
};

/// How far the line moves along each axis while the other is fixed, from its shift along the gradient in the plane
/// scaled to a square.
Shift shift_of(const physics::Plane& plane, const physics::BoundaryPoint& point) {
    const double width = plane.x.to - plane.x.from, height = plane.y.to - plane.y.from;
    const double by_x = point.error_x / width, by_y = point.error_y / height, squared = by_x * by_x + by_y * by_y;
    return {.along_x = squared / std::abs(by_x) * width, .along_y = squared / std::abs(by_y) * height};
}

Record point_record(const Described& described, const physics::BoundaryPoint& point, bool shows_angle) {
    const physics::Plane& plane = described.plane;
    const Shift shift = shift_of(plane, point);
    const Display errors{.text = described.has_errors};
    return {.entries = {{.name = "x", .unit = described.unit_x, .meaning = plane.x.name, .value = point.x, .digits = 8},
                        {.name = "y", .unit = described.unit_y, .meaning = plane.y.name, .value = point.y, .digits = 8},
                        {.name = "error_x",
                         .unit = described.unit_x,
                         .meaning = "x component of the standard error of the line, which is a shift along the "
                                    "gradient in the plane scaled to a square",
                         .value = point.error_x,
                         .shown = {.text = false}},
                        {.name = "error_y",
                         .unit = described.unit_y,
                         .meaning = "y component of the standard error of the line",
                         .value = point.error_y,
                         .shown = {.text = false}},
                        {.name = "shift_x",
                         .unit = described.unit_x,
                         .meaning = "standard error of x on the line at fixed y",
                         .value = shift.along_x,
                         .digits = 3,
                         .shown = errors},
                        {.name = "shift_y",
                         .unit = described.unit_y,
                         .meaning = "standard error of y on the line at fixed x",
                         .value = shift.along_y,
                         .digits = 3,
                         .shown = errors},
                        {.name = "angle",
                         .unit = "degree",
                         .meaning = "angle from p0 of the wave that becomes unstable",
                         .value = point.angle / degree,
                         .digits = 3,
                         .shown = {.text = shows_angle}}}};
}

List line_list(const Described& described, const physics::Boundary& boundary, bool shows_angles) {
    List lines{.name = "lines", .row = "line"};
    for (const physics::BoundaryLine& line : boundary.lines) {
        List points{.name = "points",
                    .row = "vertex",
                    .meaning = "vertices of all lines, one line after the other",
                    .group = "/boundary",
                    .max_rows = 9};
        for (const physics::BoundaryPoint& point : line.points)
            points.rows.push_back(point_record(described, point, shows_angles));
        lines.rows.push_back(
            {.heading = text("{} line of {} points", line.closed ? "closed" : "open", line.points.size()),
             .entries = {{.name = "closed",
                          .unit = "1",
                          .meaning = "1: the line ends where it begins",
                          .value = line.closed,
                          .shown = {.text = false}}},
             .lists = {std::move(points)}});
    }
    return lines;
}

List singular_point_list(const Described& described, const physics::Boundary& boundary) {
    List list{.name = "singular_points",
              .heading = "singular points",
              .row = "singular_point",
              .meaning = "cusps, double points and corners that are not resolved further",
              .prefix = "singular_"};
    for (const numerics::PlanePoint& point : boundary.singular_points)
        list.rows.push_back({.entries = {{.name = "x",
                                          .unit = described.unit_x,
                                          .meaning = described.plane.x.name,
                                          .value = point.x,
                                          .digits = 8},
                                         {.name = "y",
                                          .unit = described.unit_y,
                                          .meaning = described.plane.y.name,
                                          .value = point.y,
                                          .digits = 8}}});
    return list;
}

Record traced_record(const Described& described, const std::string& name, const std::string& convention,
                     const physics::Boundary& boundary) {
    Record record{.heading = text("{} ({} convention of lambda): {} line{}", name, convention, boundary.lines.size(),
                                  boundary.lines.size() == 1 ? "" : "s"),
                  .entries = {{.name = "limit",
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
                               .shown = {.text = false}},
                              {.name = "complete",
                               .unit = "1",
                               .meaning = "1: the lines are refined to boundary.chord",
                               .value = boundary.complete,
                               .shown = {.text = false, .archive = false}},
                              {.name = "evaluations",
                               .unit = "1",
                               .meaning = "evaluations of the stability margin",
                               .value = static_cast<std::int64_t>(boundary.evaluations),
                               .shown = {.text = false, .archive = false}}},
                  .lists = {line_list(described, boundary, name == physics::limit_name(physics::Limit::oblique)),
                            singular_point_list(described, boundary)}};
    if (!boundary.complete)
        record.footer.push_back(
            "incomplete: the limit of evaluations was reached; the lines may be coarser than boundary.chord");
    return record;
}

Record axis_record(const physics::PlaneAxis& axis, const std::string& unit) {
    const auto end = [&](const char* name, const char* which, double value) {
        return Entry{.name = name, .unit = unit, .meaning = which + axis.name, .value = value};
    };
    return {.entries = {{.name = "name", .unit = "", .meaning = "", .value = axis.name},
                        {.name = "unit", .unit = "", .meaning = "", .value = axis.unit},
                        end("from", "smallest ", axis.from),
                        end("to", "largest ", axis.to)},
            .shown = {.text = false}};
}

files::ResultTable regime_map(const Described& described, int side, Threads& threads) {
    const physics::Plane& plane = described.plane;
    std::vector<double> xs, ys, codes, relaxation;
    for (int i = 0; i < side; ++i) {
        const double fraction = (i + 0.5) / side;
        xs.push_back(plane.x.from + fraction * (plane.x.to - plane.x.from));
        ys.push_back(plane.y.from + fraction * (plane.y.to - plane.y.from));
    }
    std::vector<numerics::PlanePoint> points;
    for (const double y : ys)
        for (const double x : xs) points.push_back({x, y});
    for (const physics::RegimePoint& point : physics::regimes(plane, points, threads)) {
        codes.push_back(static_cast<double>(point.regime));
        relaxation.push_back(point.effective_relaxation);
    }
    const std::vector<std::string> axes{"map_y", "map_x"};
    return {.group = {},
            .axes = {{"map_y", described.unit_y, plane.y.name, ys}, {"map_x", described.unit_x, plane.x.name, xs}},
            .quantities = {{"regime", "1", physics::regime_legend(), axes},
                           {"effective_relaxation", "s-1", "abar = a - lambda alpha/Gamma", axes}},
            .values = {codes, relaxation}};
}

std::string plane_text(const physics::Plane& plane) {
    const auto axis = [](const char* name, const physics::PlaneAxis& one) {
        return text("{} = {}, {} to {} [{}]", name, one.name, one.from, one.to, one.unit);
    };
    return text("plane: {}; {}", axis("x", plane.x), axis("y", plane.y));
}

Record plane_record(const Described& described, const io::Scene& scene, std::size_t uncertain, bool complete,
                    List traced) {
    return {.header = {plane_text(described.plane),
                       text("every island wider than 1/{} of the plane is found; points lie on their line to "
                            "rounding",
                            scene.boundary.cells)},
            .group = "/plane",
            .entries = {{.name = "uncertain_numbers",
                         .unit = "1",
                         .meaning = "numbers with a standard error, from which the shifts of the lines follow",
                         .value = static_cast<std::int64_t>(uncertain),
                         .shown = {.text = uncertain > 0}},
                        {.name = "complete",
                         .unit = "1",
                         .meaning = "1: every line is refined to boundary.chord",
                         .value = complete,
                         .shown = {.text = false}}},
            .parts = {{"x", axis_record(described.plane.x, described.unit_x)},
                      {"y", axis_record(described.plane.y, described.unit_y)}},
            .lists = {std::move(traced)}};
}
}  // namespace

void check_boundary(const io::Scene& scene) {
    // An axis that is missing may be given with the command.
    if (scene.kind != io::SceneKind::fields || scene.boundary.x.empty() || scene.boundary.y.empty()) return;
    const PlannedBoundary planned = plan_boundary(scene);
    if (planned.has_binodal) check_binodal_plane(scene, planned.plane);
}

Result make_boundary(const io::Scene& scene, Threads& threads) {
    PlannedBoundary planned = plan_boundary(scene);
    physics::Plane& plane = planned.plane;
    const physics::Form form = physics::form(scene.model);
    const Described described{.plane = plane,
                              .unit_x = udunits(plane.x.unit, form),
                              .unit_y = udunits(plane.y.unit, form),
                              .has_errors = !planned.uncertain.empty()};
    const numerics::ContourOptions options{.cells = scene.boundary.cells, .chord = scene.boundary.chord};
    List traced{.name = "traced"};
    bool complete = true;
    for (const std::string& convention : planned.conventions) {
        plane.model.weathercock.convention = convention;
        for (const physics::Limit limit : planned.limits) {
            const physics::Boundary boundary =
                physics::trace_boundary(plane, limit, planned.uncertain, options, threads);
            complete = complete && boundary.complete;
            traced.rows.push_back(traced_record(described, physics::limit_name(limit), convention, boundary));
        }
        if (!planned.has_binodal) continue;
        const BinodalLines binodal = trace_binodal_lines(scene, plane, threads);
        Record record = traced_record(described, binodal_name, convention, binodal.boundary);
        record.footer = binodal.ends;
        traced.rows.push_back(std::move(record));
    }
    Result result{.root = plane_record(described, scene, planned.uncertain.size(), complete, std::move(traced)),
                  .attributes = {{"boundary_x", plane.x.name}, {"boundary_y", plane.y.name}}};
    plane.model.weathercock.convention = planned.conventions.front();
    if (scene.boundary.map > 0)
        result.root.parts.push_back(
            {"map",
             {.group = "/map", .maps = regime_map(described, scene.boundary.map, threads), .shown = {.text = false}}});
    return result;
}

}  // namespace drover::run
