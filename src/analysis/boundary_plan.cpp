// analysis/boundary_plan.cpp: from the text of a plane to its axes; vertices, lines and planes as records.
#include "analysis/boundary_plan.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "base/log.hpp"
#include "base/mapped.hpp"
#include "model/start.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/number_lists.hpp"

namespace drover::analysis {

namespace {
void check_range(const std::string& list, const std::string& written, const Range& range, double value,
                 const SourceLocation& where) {
    const bool low = range.min_open ? value <= range.min : value < range.min;
    require(!low && value <= range.max, where, "{} has \"{}\": {} is out of the range of its key; expected {} {}{}",
            list, written, value, range.min_open ? ">" : ">=", range.min,
            std::isfinite(range.max) ? text(" and <= {}", range.max) : "");
}

/// Rods and beads do not read a number that their table replaces, nor noise in boundaries.
void check_is_read(const physics::ModelValues& model, const std::string& list, const std::string& key,
                   const SourceLocation& where) {
    const physics::Equations equations(model);
    for (const auto& [number, coefficient] : equations.coefficients)
        require(key != number || coefficient.table() == nullptr, where,
                "{} names {}, which the scene takes from its table; choose a number that the model reads", list, key);
    const bool is_area = key.starts_with("uniform.") && key.ends_with("_area");
    require(!key.starts_with("noise.") && !is_area, where,
            "{} names {}, which does not affect phase boundaries; choose another number", list, key);
}

/// A number of the model for examples.
std::string example_key(const io::Scene& scene) {
    if (scene.kind != io::SceneKind::model) return scene.model.file->coefficients.front().key();
    return "coefficients.a";
}

/// "key = from:to", an axis of a plane.
struct KeyRange {
    std::string key;
    double from = 0.0, to = 1.0;
};

KeyRange read_axis(const std::string& list, const std::string& written, const std::string& example,
                   const SourceLocation& where) {
    require(!written.empty(), where,
            "{} is not given; expected a number of the model and its range, such as {}: set it in the scene, or by "
            "--{}",
            list, example, list.substr(list.find('.') + 1));
    const auto [key, value] = run::read_assignment(written, list, example, where);
    const std::vector<std::string> ends = run::split(value, ':');
    require(ends.size() == 2, where, "{} has \"{}\"; expected first:last, as in {}", list, written, example);
    const KeyRange axis{.key = key,
                        .from = run::read_number(ends[0], written, list, example, where),
                        .to = run::read_number(ends[1], written, list, example, where)};
    require(axis.from < axis.to, where, "{} has \"{}\"; expected the smaller number first", list, written);
    return axis;
}

PlaneAxis axis_of(const io::Scene& scene, const std::string& list, const std::string& written) {
    const SourceLocation where = io::locate(scene, list);
    const bool is_own = scene.kind == io::SceneKind::model;
    const auto [key, from, to] = read_axis(list, written, text("\"{} = 0.5:2\"", example_key(scene)), where);
    PlaneAxis axis{plane_number(scene, list, key, where)};
    axis.udunits = axis.unit, axis.from = from, axis.to = to;
    if (is_own) return axis;
    if (axis.is_fraction) {
        require(from > 0.0, where, "{} has \"{}\"; expected area fractions above 0", list, written);
        return axis;
    }
    axis.udunits = physics::unit_of(scene.model, axis.unit);
    check_is_read(scene.model, list, key, where);
    check_range(list, written, axis.range, from, where);
    check_range(list, written, axis.range, to, where);
    return axis;
}

std::vector<std::pair<PlaneNumber, double>> errors_of(const io::Scene& scene, const PlannedBoundary& planned) {
    std::vector<std::pair<PlaneNumber, double>> errors;
    const bool is_own = scene.kind == io::SceneKind::model;
    const std::string list = "boundary.errors", example = text("\"{} = 0.02\"", example_key(scene));
    const SourceLocation where = io::locate(scene, list);
    for (const std::string& written : scene.boundary.errors) {
        const auto [given, value] = run::read_assignment(written, list, example, where);
        const double error = run::read_number(value, written, list, example, where);
        require(error > 0.0, where, "{} has \"{}\"; expected a standard error > 0", list, written);
        const PlaneNumber number = plane_number(scene, list, given, where);
        const std::string& key = number.name;
        for (const PlaneAxis* axis : {&planned.x, &planned.y})
            require(!are_same(number, *axis), where,
                    "{} names {}, which the axis {} of the plane sets exactly; expected another number", list, key,
                    axis->name);
        if (!is_own && io::is_from_table(scene, key)) {
            log_warning("{} names {}, whose error is that of {}; its error here is not used", list, key,
                        scene.calibrated.table);
            continue;
        }
        if (!is_own) check_is_read(scene.model, list, key, where);
        for (const auto& [other, its_error] : errors)
            require(!are_same(number, other), where, "{} has two errors of {}; expected each number once", list, key);
        errors.emplace_back(number, error);
    }
    return errors;
}

std::vector<std::string> conventions_of(const io::Scene& scene) {
    if (scene.kind == io::SceneKind::model) {
        require(scene.boundary.conventions.empty(), io::locate(scene, "boundary.conventions"),
                "boundary.conventions is for the equations of rods and beads; expected a scene without it");
        return {""};
    }
    const physics::CoefficientRow* row = physics::with_conventions(*scene.model.file);
    const std::string& of_scene = word(scene.model, row->factor_key);
    if (scene.boundary.conventions.empty()) return {of_scene};
    if (io::is_from_table(scene, row->key()))
        for (const std::string& convention : scene.boundary.conventions)
            require(
                convention == of_scene, io::locate(scene, "boundary.conventions"),
                "boundary.conventions has \"{}\", but {} comes from a table in the convention {} = \"{}\"; expected "
                "that one: choose by {}",
                convention, row->symbol, row->factor_key, of_scene, row->factor_key);
    return scene.boundary.conventions;
}

std::vector<std::string> lines_in(const io::Scene& scene) {
    const bool has_direction = has_order(scene);
    if (scene.kind == io::SceneKind::model && scene.boundary.lines == io::BoundaryPlan{}.lines) {
        std::vector<std::string> states{isotropic_line};
        if (has_direction) states.emplace_back(ordered_line);
        return states;
    }
    const std::vector<std::string>& known = line_names();
    const SourceLocation where = io::locate(scene, "boundary.lines");
    std::vector<std::string> lines = scene.boundary.lines;
    require(!lines.empty(), where, "boundary.lines is empty; expected at least one of {}", joined(known));
    for (const std::string& name : lines) {
        require(std::ranges::find(known, name) != known.end(), where, "boundary.lines has \"{}\"; expected one of {}",
                name, joined(known));
        const bool is_of_scalars =
            name == name_of(theory::Limit::phase_separation) || name == binodal_name || name == isotropic_line;
        require(has_direction || is_of_scalars, where,
                "boundary.lines has \"{}\", and no field of the model has a direction; expected isotropic, "
                "phase-separation or binodal",
                name);
    }
    std::stable_partition(lines.begin(), lines.end(), [](const std::string& name) { return name != binodal_name; });
    return lines;
}

/// Throws an input Error where no axis of the plane is the density of a field.
void check_binodal_plane(const io::Scene& scene, const PlannedBoundary& planned) {
    const model::Equations equations = run::equations_of(scene);
    std::string example = "which the model does not have";
    for (const model::Field& field : equations.model().fields)
        if (field.spin == 0 && field.conserved) example = "such as uniform." + field.name;
    require(density_component(equations, planned.x) >= 0 || density_component(equations, planned.y) >= 0,
            io::locate(scene, "boundary.lines"),
            "boundary.lines has \"binodal\", the densities of coexisting phases, and the axes are {} and {}; expected "
            "the mean density of a field as one axis, {}",
            planned.x.name, planned.y.name, example);
}

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

const std::vector<std::string>& line_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all = all_names<theory::Limit>();
        all.insert(all.end(), {binodal_name, isotropic_line, ordered_line});
        return all;
    }();
    return names;
}

bool has_order(const io::Scene& scene) { return theory::order_component(run::equations_of(scene)) >= 0; }

int density_component(const model::Equations& equations, const PlaneNumber& number) {
    int at = 0;
    for (const model::StateComponent& one : model::components_of_state(equations)) {
        if (equations.model().fields[one.field].name == number.density) return at;
        ++at;
    }
    return -1;
}

PlannedBoundary plan_boundary(const io::Scene& scene) {
    PlannedBoundary planned;
    planned.cells = scene.boundary.cells;
    planned.x = axis_of(scene, "boundary.x", scene.boundary.x);
    planned.y = axis_of(scene, "boundary.y", scene.boundary.y);
    require(!are_same(planned.x, planned.y), io::locate(scene, "boundary.y"),
            "boundary.x is {} and boundary.y is {}; expected two different numbers", planned.x.name, planned.y.name);
    planned.errors = errors_of(scene, planned);
    planned.conventions = conventions_of(scene);
    planned.lines = lines_in(scene);
    if (planned.lines.back() == binodal_name) check_binodal_plane(scene, planned);
    return planned;
}

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
                        run::data_only(run::flag(
                            "complete", "1: every line is refined to boundary.chord, and no binodal has a note",
                            complete))},
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
