// run/boundary_records.cpp: vertices, lines and planes as records.
#include "run/boundary_records.hpp"

#include <cmath>

#include "base/constants.hpp"

namespace drover::run {

namespace {

struct Shift {
    double along_x = 0.0, along_y = 0.0;
};

/// How far the line moves along each axis while the other is fixed, from its shift along the gradient in the plane
/// scaled to a square.
Shift shift_of(const DescribedPlane& plane, const model::BoundaryPoint& point) {
    const double width = plane.x.to - plane.x.from, height = plane.y.to - plane.y.from;
    const double by_x = point.error_x / width, by_y = point.error_y / height, squared = by_x * by_x + by_y * by_y;
    return {.along_x = squared / std::abs(by_x) * width, .along_y = squared / std::abs(by_y) * height};
}

std::vector<Entry> wave_entries(const model::Margin& at) {
    return {{.name = "wavenumber",
             .unit = "mm-1",
             .meaning = "|q| of the wave that becomes unstable; 0: the limit of long waves, or a uniform change",
             .value = at.q},
            {.name = "wave_frequency",
             .unit = "s-1",
             .meaning = "its angular frequency, -Im s; 0 in the limit of long waves",
             .value = at.frequency}};
}

Record point_record(const DescribedPlane& plane, const DescribedLines& described, const model::BoundaryPoint& point) {
    const Shift shift = shift_of(plane, point);
    const Display errors{.text = plane.uncertain > 0};
    Record record{
        .entries = {{.name = "x", .unit = plane.x.udunits, .meaning = plane.x.name, .value = point.x, .digits = 8},
                    {.name = "y", .unit = plane.y.udunits, .meaning = plane.y.name, .value = point.y, .digits = 8},
                    {.name = "error_x",
                     .unit = plane.x.udunits,
                     .meaning = "x component of the standard error of the line, which is a shift along the "
                                "gradient in the plane scaled to a square",
                     .value = point.error_x,
                     .shown = {.text = false}},
                    {.name = "error_y",
                     .unit = plane.y.udunits,
                     .meaning = "y component of the standard error of the line",
                     .value = point.error_y,
                     .shown = {.text = false}},
                    {.name = "shift_x",
                     .unit = plane.x.udunits,
                     .meaning = "standard error of x on the line at fixed y",
                     .value = shift.along_x,
                     .digits = 3,
                     .shown = errors},
                    {.name = "shift_y",
                     .unit = plane.y.udunits,
                     .meaning = "standard error of y on the line at fixed x",
                     .value = shift.along_y,
                     .digits = 3,
                     .shown = errors},
                    {.name = "angle",
                     .unit = "degree",
                     .meaning = "angle from the order of the wave that becomes unstable",
                     .value = point.at.angle / radians_per_degree,
                     .digits = 3,
                     .shown = {.text = described.shows_angles}}}};
    if (described.shows_waves)
        for (Entry& entry : wave_entries(point.at)) record.entries.push_back(std::move(entry));
    return record;
}

List line_list(const DescribedPlane& plane, const DescribedLines& described, const model::Boundary& boundary) {
    List lines{.name = "lines", .row = "line"};
    for (const model::BoundaryLine& line : boundary.lines) {
        List points{.name = "points",
                    .row = "vertex",
                    .meaning = "vertices of all lines, one line after the other",
                    .group = "/boundary",
                    .max_rows = 9};
        for (const model::BoundaryPoint& point : line.points)
            points.rows.push_back(point_record(plane, described, point));
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

List singular_point_list(const DescribedPlane& plane, const model::Boundary& boundary) {
    List list{.name = "singular_points",
              .heading = "singular points",
              .row = "singular_point",
              .meaning = "cusps, double points and corners that are not resolved further",
              .prefix = "singular_"};
    for (const numerics::PlanePoint& point : boundary.singular_points)
        list.rows.push_back(
            {.entries = {
                 {.name = "x", .unit = plane.x.udunits, .meaning = plane.x.name, .value = point.x, .digits = 8},
                 {.name = "y", .unit = plane.y.udunits, .meaning = plane.y.name, .value = point.y, .digits = 8}}});
    return list;
}

Record axis_record(const DescribedAxis& axis) {
    const auto end = [&](const char* name, const char* which, double value) {
        return Entry{.name = name, .unit = axis.udunits, .meaning = which + axis.name, .value = value};
    };
    return {.entries = {{.name = "name", .unit = "", .meaning = "", .value = axis.name},
                        {.name = "unit", .unit = "", .meaning = "", .value = axis.unit},
                        end("from", "smallest ", axis.from),
                        end("to", "largest ", axis.to)},
            .shown = {.text = false}};
}
}  // namespace

Record traced_record(const DescribedPlane& plane, const DescribedLines& described, const model::Boundary& boundary) {
    Record record{.heading = text("{}: {} line{}", described.heading, boundary.lines.size(),
                                  boundary.lines.size() == 1 ? "" : "s"),
                  .entries = described.names};
    record.entries.push_back({.name = "complete",
                              .unit = "1",
                              .meaning = "1: the lines are refined to boundary.chord",
                              .value = boundary.complete,
                              .shown = {.text = false, .archive = false}});
    record.entries.push_back({.name = "evaluations",
                              .unit = "1",
                              .meaning = "evaluations of the stability margin",
                              .value = static_cast<std::int64_t>(boundary.evaluations),
                              .shown = {.text = false, .archive = false}});
    record.lists = {line_list(plane, described, boundary), singular_point_list(plane, boundary)};
    if (!boundary.complete)
        record.footer.push_back(
            "incomplete: the limit of evaluations was reached; the lines may be coarser than boundary.chord");
    return record;
}

Record plane_record(const DescribedPlane& plane, bool complete, List traced) {
    const auto axis_text = [](const char* name, const DescribedAxis& one) {
        return text("{} = {}, {} to {} [{}]", name, one.name, one.from, one.to, one.unit);
    };
    return {.header = {text("plane: {}; {}", axis_text("x", plane.x), axis_text("y", plane.y)),
                       text("every island wider than 1/{} of the plane is found; points lie on their line to "
                            "rounding",
                            plane.cells)},
            .group = "/plane",
            .entries = {{.name = "uncertain_numbers",
                         .unit = "1",
                         .meaning = "numbers with a standard error, from which the shifts of the lines follow",
                         .value = static_cast<std::int64_t>(plane.uncertain),
                         .shown = {.text = plane.uncertain > 0}},
                        {.name = "complete",
                         .unit = "1",
                         .meaning = "1: every line is refined to boundary.chord",
                         .value = complete,
                         .shown = {.text = false}}},
            .parts = {{"x", axis_record(plane.x)}, {"y", axis_record(plane.y)}},
            .lists = {std::move(traced)}};
}

MapPoints map_points(const DescribedPlane& plane, int side) {
    const auto middles = [side](const DescribedAxis& axis) {
        std::vector<double> values;
        for (int i = 0; i < side; ++i) values.push_back(axis.from + (i + 0.5) / side * (axis.to - axis.from));
        return values;
    };
    const std::vector<double> xs = middles(plane.x), ys = middles(plane.y);
    MapPoints map{.points = {},
                  .axes = {{"map_y", plane.y.udunits, plane.y.name, ys}, {"map_x", plane.x.udunits, plane.x.name, xs}}};
    for (const double y : ys)
        for (const double x : xs) map.points.push_back({x, y});
    return map;
}

}  // namespace drover::run
