// analysis/boundary_records.cpp: vertices, lines and planes as records.
#include "analysis/boundary_plan.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "base/mapped.hpp"

namespace drover::analysis {

namespace {

std::vector<run::Entry> wave_entries(const theory::Margin& at) {
    return {run::number("wavenumber", "mm-1",
                        "|q| of the wave that becomes unstable; 0: the limit of long waves, or a uniform change", at.q),
            run::number("wave_frequency", "s-1", "its angular frequency, -Im s; 0 in the limit of long waves",
                        at.frequency)};
}

run::Record point_record(const PlannedBoundary& plane, const DescribedLines& described,
                         const theory::BoundaryPoint& point) {
    const auto end = [&](const char* name, const PlaneAxis& axis, const char* words, double value) {
        return run::shown_as(run::number(name, axis.udunits, words, value, 4), {.text = plane.draws > 0});
    };
    run::Record record{
        .entries = {run::number("x", plane.x.udunits, plane.x.name, point.x, 8),
                    run::number("y", plane.y.udunits, plane.y.name, point.y, 8),
                    end("x_low", plane.x, "smallest x of the error band (16 to 84 % of the draws unstable) at this y",
                        point.band.x_low),
                    end("x_high", plane.x, "largest x of the error band at this y", point.band.x_high),
                    end("y_low", plane.y, "smallest y of the error band at this x", point.band.y_low),
                    end("y_high", plane.y, "largest y of the error band at this x", point.band.y_high),
                    run::shown_as(run::number("angle", "degree",
                                              "angle from the order of the wave that becomes unstable",
                                              point.at.angle / radians_per_degree, 3),
                                  {.text = described.shows_angles})}};
    if (described.shows_waves)
        for (run::Entry& entry : wave_entries(point.at)) record.entries.push_back(std::move(entry));
    return record;
}

run::List line_list(const PlannedBoundary& plane, const DescribedLines& described, const theory::Boundary& boundary) {
    run::List lines{.name = "lines", .row = "line"};
    for (const theory::BoundaryLine& line : boundary.lines) {
        run::List points{.name = "points",
                         .row = "vertex",
                         .meaning = "vertices of all lines, one line after the other",
                         .group = "/boundary",
                         .max_rows = 9};
        for (const theory::BoundaryPoint& point : line.points)
            points.rows.push_back(point_record(plane, described, point));
        lines.rows.push_back(
            {.heading = text("{} line of {} points", line.closed ? "closed" : "open", line.points.size()),
             .entries = {run::data_only(run::flag("closed", "1: the line ends where it begins", line.closed))},
             .lists = {std::move(points)}});
    }
    return lines;
}

run::List singular_point_list(const PlannedBoundary& plane, const theory::Boundary& boundary) {
    run::List list{.name = "singular_points",
                   .heading = "singular points",
                   .row = "singular_point",
                   .meaning = "cusps, double points and corners that are not resolved further",
                   .prefix = "singular_"};
    for (const numerics::PlanePoint& point : boundary.singular_points)
        list.rows.push_back({.entries = {run::number("x", plane.x.udunits, plane.x.name, point.x, 8),
                                         run::number("y", plane.y.udunits, plane.y.name, point.y, 8)}});
    return list;
}

/// What the draws say about the lines of one kind.
void add_draws(const PlannedBoundary& plane, const theory::Boundary& boundary, run::Record& record) {
    const auto add = [&](const char* name, const char* meaning, double value) {
        record.entries.push_back(run::json_only(run::number(name, "1", meaning, value)));
    };
    if (!boundary.field) return;
    const theory::DrawField& field = *boundary.field;
    add("valid_draws", "draws of the uncertain numbers whose model is valid", static_cast<double>(field.draws));
    add("share_with_line", "fraction of these draws that have a line in the plane", field.with_line);
    add("share_with_more", "fraction of these draws that have more lines than the plane without errors",
        field.with_more);
    const auto percent = [](double share) { return text("{:.3g} %", 100.0 * share); };
    std::string words = text("{} of {} draws have a line", percent(field.with_line), field.draws);
    if (field.with_more > 0.0) words += text("; {} have more lines than this", percent(field.with_more));
    if (field.draws < plane.draws)
        words += text("; {} more are no valid models and are left out", plane.draws - field.draws);
    record.footer.push_back(words);
}

/// Of a plane without lines: on which side of them it lies.
std::string whole_plane(const theory::Boundary& boundary) {
    const double exists = boundary.stable + boundary.unstable;
    if (exists == 0.0) return "the state does not exist in this plane";
    if (boundary.stable > 0.0 && boundary.unstable > 0.0)
        return text("the state is stable in {:.3g} % and unstable in {:.3g} % of this plane, with no line between them",
                    100.0 * boundary.stable, 100.0 * boundary.unstable);
    const std::string where =
        exists == 1.0 ? "everywhere in this plane" : text("where it exists, in {:.3g} % of this plane", 100.0 * exists);
    return text("the state is {} {}", boundary.stable > 0.0 ? "stable" : "unstable", where);
}

run::Record axis_record(const PlaneAxis& axis) {
    return {.entries = {run::words("name", "", axis.name), run::words("unit", "", axis.unit),
                        run::number("from", axis.udunits, "smallest " + axis.name, axis.from),
                        run::number("to", axis.udunits, "largest " + axis.name, axis.to)},
            .shown = {.text = false}};
}
}  // namespace

run::Record traced_record(const PlannedBoundary& plane, const DescribedLines& described,
                          const theory::Boundary& boundary) {
    run::Record record{.heading = text("{}: {} line{}", described.heading, boundary.lines.size(),
                                       boundary.lines.size() == 1 ? "" : "s"),
                       .entries = described.names};
    record.entries.push_back(
        run::json_only(run::flag("complete", "1: the lines are refined to boundary.chord", boundary.complete)));
    record.entries.push_back(
        run::json_only(run::count("evaluations", "evaluations of the stability margin", boundary.evaluations)));
    record.entries.push_back(
        run::json_only(run::count("poles", "vertices that are left out: the margin changes its sign there by diverging",
                                  boundary.poles)));
    record.entries.push_back(run::json_only(
        run::number("share_stable", "1", "fraction of the plane in which the state is stable", boundary.stable)));
    record.entries.push_back(run::json_only(
        run::number("share_unstable", "1", "fraction of the plane in which the state is unstable", boundary.unstable)));
    record.lists = {line_list(plane, described, boundary), singular_point_list(plane, boundary)};
    add_draws(plane, boundary, record);
    if (boundary.lines.empty()) record.footer.push_back(whole_plane(boundary));
    if (!boundary.complete)
        record.footer.push_back(
            "incomplete: the limit of evaluations was reached; the lines may be coarser than boundary.chord");
    if (boundary.poles > 0)
        record.footer.push_back(
            text("left out: {} vertices where the margin changes its sign by diverging, as at a pole of a coefficient "
                 "or at the edge of a logarithm",
                 boundary.poles));
    return record;
}

run::Record plane_record(const PlannedBoundary& plane, bool complete, run::List traced) {
    const auto axis_text = [](const char* name, const PlaneAxis& one) {
        return text("{} = {}, {} to {} [{}]", name, one.name, one.from, one.to, one.unit);
    };
    return {.header = {text("plane: {}; {}", axis_text("x", plane.x), axis_text("y", plane.y)),
                       text("every island wider than 1/{} of the plane is found; points lie on their line to "
                            "rounding",
                            plane.cells)},
            .group = "/plane",
            .entries = {run::shown_as(run::count("draws",
                                                 "draws of all numbers with errors, from which the error bands follow",
                                                 plane.draws),
                                      {.text = plane.draws > 0}),
                        run::data_only(run::flag("complete", "1: every line is refined to boundary.chord", complete))},
            .parts = {{"x", axis_record(plane.x)}, {"y", axis_record(plane.y)}},
            .lists = {std::move(traced)}};
}

void BandMaps::add(const DescribedLines& described, const theory::Boundary& boundary) {
    if (!boundary.field) return;
    names_.push_back(described.names);
    fields_.push_back(*boundary.field);
}

void BandMaps::add_to(run::Record& root) const {
    if (fields_.empty()) return;
    const int side = fields_.front().side;
    const auto places = [&](const char* name, const PlaneAxis& axis) {
        files::Axis found{name, axis.udunits, axis.name, {}};
        for (int i = 0; i < side; ++i) found.values.push_back(axis.from + (axis.to - axis.from) * i / (side - 1));
        return found;
    };
    files::ResultTable table{.group = {},
                             .axes = {{"band_line", "1", "kind of line", {}},
                                      places("band_y", plane_.y),
                                      places("band_x", plane_.x)}};
    for (std::size_t n = 0; n < fields_.size(); ++n) table.axes.front().values.push_back(static_cast<double>(n));
    const std::vector<std::string> axes{"band_line", "band_y", "band_x"};
    table.quantities = {{"share", "1", "fraction of the draws with this state in which it is unstable", axes},
                        {"deviation", "1",
                         "margin of stability over its error: 1 where 16 % of the draws are unstable, -1 where 84 % "
                         "are; the error band lies between",
                         axes}};
    table.values.resize(2);
    for (const theory::DrawField& field : fields_) {
        table.values[0].insert(table.values[0].end(), field.share.begin(), field.share.end());
        table.values[1].insert(table.values[1].end(), field.deviation.begin(), field.deviation.end());
    }
    for (std::size_t i = 0; i < names_.front().size(); ++i) {
        const run::Entry& first = names_.front()[i];
        table.quantities.push_back({first.name, "1", run::stored_meaning(first), {"band_line"}});
        table.values.push_back(
            mapped(names_, [i](const std::vector<run::Entry>& names) { return run::stored_value(names[i]); }));
    }
    root.parts.push_back({"band", {.group = "/band", .maps = std::move(table), .shown = {.text = false}}});
}

MapPoints map_points(const PlannedBoundary& plane, int side) {
    const auto middles = [side](const PlaneAxis& axis) {
        return mapped(std::views::iota(0, side),
                      [&](int i) { return axis.from + (i + 0.5) / side * (axis.to - axis.from); });
    };
    const std::vector<double> xs = middles(plane.x), ys = middles(plane.y);
    MapPoints map{.points = {},
                  .axes = {{"map_y", plane.y.udunits, plane.y.name, ys}, {"map_x", plane.x.udunits, plane.x.name, xs}}};
    for (const double y : ys)
        for (const double x : xs) map.points.push_back({x, y});
    return map;
}

}  // namespace drover::analysis
