// run/boundary.cpp: from the text of a plane to its lines and its map.
#include "drover/run/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "run/written_values.hpp"

namespace drover::run {

namespace {
constexpr double degree = std::numbers::pi / 180.0;

/// Area fractions are no numbers of the model: densities times what one particle covers.
struct Fraction {
    const char* name;
    const char* area_key;
    double physics::UniformState::*density;
    double physics::UniformState::*area;
};
constexpr Fraction fractions[] = {{"bead_area_fraction", "uniform.bead_area", &physics::UniformState::bead_density,
                                   &physics::UniformState::bead_area},
                                  {"rod_area_fraction", "uniform.rod_area", &physics::UniformState::rod_density,
                                   &physics::UniformState::rod_area}};

void check_range(const std::string& list, const std::string& written, const Range& range, double value,
                 const SourceLocation& where) {
    const bool low = range.min_open ? value <= range.min : value < range.min;
    require(!low && value <= range.max, where, "{} has \"{}\": {} is out of the range of its key; expected {} {}{}",
            list, written, value, range.min_open ? ">" : ">=", range.min,
            std::isfinite(range.max) ? text(" and <= {}", range.max) : "");
}

/// A number whose place a table has taken moves nothing.
void check_not_tabulated(const physics::Model& model, const std::string& list, const std::string& key,
                         const SourceLocation& where) {
    const physics::Equations equations(model);
    for (const auto& [number, coefficient] : named(equations))
        require(key != number || coefficient->table() == nullptr, where,
                "{} names {}, which the scene takes from its table; choose a number that the model reads", list, key);
}

/// What no uniform state knows of.
void check_moves(const std::string& list, const std::string& key, const SourceLocation& where) {
    require(!key.starts_with("noise.") && key != "uniform.rod_area" && key != "uniform.bead_area", where,
            "{} names {}, which moves no boundary; choose another number", list, key);
}

/// 0 for a key of the bead density, 1 for one of the rods', -1 for others.
int density_of(const std::string& key) {
    if (key == "uniform.bead_density" || key == "bead_area_fraction") return 0;
    return key == "uniform.rod_density" || key == "rod_area_fraction" ? 1 : -1;
}

physics::PlaneAxis axis_of(const io::Scene& scene, const std::string& list, const std::string& written) {
    const SourceLocation where = io::location_of(scene, list);
    const std::string example = "\"driving.strength = 0.5:2\"";
    require(
        !written.empty(), where,
        "{} is not given; expected a number of the model and its range, such as {}: set it in the scene, or by --{}",
        list, example, list.substr(list.find('.') + 1));
    const auto [key, value] = read_written(written, list, example, where);
    const std::vector<std::string> ends = split(value, ':');
    require(ends.size() == 2, where, "{} has \"{}\"; expected first:last, as in {}", list, written, example);
    physics::PlaneAxis axis{.name = key,
                            .unit = "1",
                            .from = read_number(ends[0], written, list, example, where),
                            .to = read_number(ends[1], written, list, example, where)};
    require(axis.from < axis.to, where, "{} has \"{}\"; expected the smaller number first", list, written);
    for (const Fraction& fraction : fractions) {
        if (key != fraction.name) continue;
        const double area = scene.model.uniform.*fraction.area;
        require(area > 0.0, io::location_of(scene, fraction.area_key),
                "{} has \"{}\", and {} = {} does not say what one covers; expected > 0 [mm^2]", list, written,
                fraction.area_key, area);
        require(axis.from > 0.0, where, "{} has \"{}\"; expected area fractions above 0", list, written);
        axis.is_density = true;
        axis.set = [fraction, area](physics::Model& model, double covered) {
            model.uniform.*fraction.density = covered / area;
        };
        return axis;
    }
    const io::ModelNumber number = io::model_number(key, where, scene.model);
    check_not_tabulated(scene.model, list, key, where);
    check_moves(list, key, where);
    check_range(list, written, number.range, axis.from, where);
    check_range(list, written, number.range, axis.to, where);
    axis.unit = number.unit.empty() ? "1" : number.unit;
    axis.is_density = key == "uniform.bead_density" || key == "uniform.rod_density";
    axis.set = [in = number.in](physics::Model& model, double held) { in(model) = held; };
    return axis;
}

std::vector<physics::Uncertain> uncertain_numbers(const io::Scene& scene, const physics::PlaneAxis& x,
                                                  const physics::PlaneAxis& y) {
    std::vector<physics::Uncertain> result = physics::table_errors(scene.model);
    const std::string list = "boundary.errors", example = "\"relaxation.rate = 0.02\"";
    const SourceLocation where = io::location_of(scene, list);
    for (const std::string& written : scene.boundary.errors) {
        const auto [key, value] = read_written(written, list, example, where);
        const double error = read_number(value, written, list, example, where);
        require(error > 0.0, where, "{} has \"{}\"; expected a standard error > 0", list, written);
        require(key != x.name && key != y.name, where,
                "{} names {}, an axis of the plane, whose place is given; expected another number", list, key);
        const io::ModelNumber number = io::model_number(key, where, scene.model);
        check_not_tabulated(scene.model, list, key, where);
        check_moves(list, key, where);
        require(density_of(key) < 0 || (density_of(key) != density_of(x.name) && density_of(key) != density_of(y.name)),
                where, "{} names {}, a density whose place in the plane is given; expected another number", list, key);
        result.push_back({.name = key, .error = error, .add = [in = number.in](physics::Model& model, double change) {
                              in(model) += change;
                          }});
    }
    return result;
}

Regime regime_of(double onset, double separation, double banding, double oblique) {
    if (std::isnan(onset)) return Regime::none;
    if (onset >= 0.0) return separation < 0.0 ? Regime::separating : Regime::isotropic;
    if (std::isnan(banding)) return Regime::none;
    if (banding < 0.0) return Regime::banding;
    return oblique < 0.0 ? Regime::oblique : Regime::flock;
}

void add_map(const physics::Plane& plane, Threads& threads, BoundaryReport& report) {
    const int side = report.scene.boundary.map;
    if (side == 0) return;
    std::vector<numerics::PlanePoint> points;
    for (int i = 0; i < side; ++i) {
        const double part = (i + 0.5) / side;
        report.map_x.push_back(plane.x.from + part * (plane.x.to - plane.x.from));
        report.map_y.push_back(plane.y.from + part * (plane.y.to - plane.y.from));
    }
    for (const double y : report.map_y)
        for (const double x : report.map_x) points.push_back({x, y});
    const auto at = [&](physics::Limit limit) { return physics::margins(plane, points, limit, threads); };
    const auto onset = at(physics::Limit::onset), separation = at(physics::Limit::phase_separation),
               banding = at(physics::Limit::banding), oblique = at(physics::Limit::oblique);
    for (std::size_t n = 0; n < points.size(); ++n) {
        report.regimes.push_back(regime_of(onset[n].value, separation[n].value, banding[n].value, oblique[n].value));
        report.effective_relaxation.push_back(onset[n].value);
    }
}
}  // namespace

BoundaryReport make_boundary(const io::Scene& scene, Threads& threads) {
    const io::BoundaryPlan& plan = scene.boundary;
    BoundaryReport report{.scene = scene,
                          .x = axis_of(scene, "boundary.x", plan.x),
                          .y = axis_of(scene, "boundary.y", plan.y)};
    require(report.x.name != report.y.name &&
                (density_of(report.x.name) < 0 || density_of(report.x.name) != density_of(report.y.name)),
            io::location_of(scene, "boundary.y"),
            "boundary.x is {} and boundary.y is {}; expected two different numbers", report.x.name, report.y.name);
    require(!plan.lines.empty(), io::location_of(scene, "boundary.lines"),
            "boundary.lines is empty; expected at least one of onset, "
            "phase-separation, banding, oblique");
    const std::vector<physics::Uncertain> uncertain = uncertain_numbers(scene, report.x, report.y);
    report.uncertain = uncertain.size();
    physics::Plane plane{.model = scene.model, .x = report.x, .y = report.y};
    std::vector<std::string> conventions = plan.conventions;
    if (conventions.empty()) conventions.push_back(scene.model.weathercock.convention);
    const bool of_table = io::is_from_table(scene, "weathercock.strength");
    for (const std::string& convention : conventions)
        require(
            !of_table || convention == scene.model.weathercock.convention,
            io::location_of(scene, "boundary.conventions"),
            "boundary.conventions has \"{}\", and the lambda of the scene is from a table, as weathercock.convention = "
            "\"{}\" has it; expected no other: choose by weathercock.convention",
            convention, scene.model.weathercock.convention);
    const numerics::ContourOptions options{.cells = plan.cells, .chord = plan.chord};
    for (const std::string& convention : conventions) {
        plane.model.weathercock.convention = convention;
        for (const std::string& name : plan.lines) {
            const physics::Limit limit = physics::limit_of(name);
            report.traced.push_back(
                {limit, convention, physics::trace_boundary(plane, limit, uncertain, options, threads)});
        }
    }
    plane.model.weathercock.convention = conventions.front();
    add_map(plane, threads, report);
    return report;
}

namespace {
/// Some points of a line, its ends among them.
std::vector<std::size_t> chosen_points(std::size_t count) {
    constexpr std::size_t most = 9;
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < std::min(count, most); ++i)
        chosen.push_back(i * (count - 1) / (std::min(count, most) - 1));
    return chosen;
}

/// How far the line moves along one axis, the other being held: the shift along the gradient, in a plane laid on a square, seen from that axis.
double shift_along(const BoundaryReport& report, const physics::BoundaryPoint& point, bool x) {
    const double by_x = point.error_x / (report.x.to - report.x.from),
                 by_y = point.error_y / (report.y.to - report.y.from);
    return (by_x * by_x + by_y * by_y) / std::abs(x ? by_x : by_y) *
           (x ? report.x.to - report.x.from : report.y.to - report.y.from);
}

void add_line(const BoundaryReport& report, const physics::BoundaryLine& line, std::string& out) {
    const bool angles = line.limit == physics::Limit::oblique, errors = report.uncertain > 0;
    out += text("  {} of {} points\n", line.closed ? "closed" : "open", line.points.size());
    out +=
        text("  {:>24} {:>24}{}{}\n", report.x.name, report.y.name,
             errors ? text(" {:>12} {:>12}", "shift in x", "shift in y") : "", angles ? text(" {:>10}", "angle") : "");
    for (const std::size_t i : chosen_points(line.points.size())) {
        const physics::BoundaryPoint& point = line.points[i];
        out += text("  {:>24.8g} {:>24.8g}", point.x, point.y);
        if (errors)
            out += text(" {:>12.3g} {:>12.3g}", shift_along(report, point, true), shift_along(report, point, false));
        if (angles) out += text(" {:>10.1f}", point.angle / degree);
        out += '\n';
    }
}
}  // namespace

std::string boundary_text(const BoundaryReport& report) {
    std::string out = text("plane: {} = {} to {} [{}], {} = {} to {} [{}]\n", report.x.name, report.x.from, report.x.to,
                           report.x.unit, report.y.name, report.y.from, report.y.to, report.y.unit);
    out += text("islands wider than 1/{} of the plane are found for certain; points lie on their line to rounding\n",
                report.scene.boundary.cells);
    if (report.uncertain > 0)
        out += text(
            "shifts: standard errors of where the line runs, along x at the same y and along y at the same x, from "
            "those of {} numbers\n",
            report.uncertain);
    for (const TracedLines& traced : report.traced) {
        const physics::Boundary& boundary = traced.boundary;
        out += text("\n{} (lambda: {}): {} line{}\n", physics::limit_name(traced.limit), traced.convention,
                    boundary.lines.size(), boundary.lines.size() == 1 ? "" : "s");
        for (const physics::BoundaryLine& line : boundary.lines) add_line(report, line, out);
        for (const numerics::PlanePoint& point : boundary.sharp)
            out += text("  sharp at {:.8g}, {:.8g}\n", point.x, point.y);
        if (!boundary.complete)
            out += "  not complete: refined until too many evaluations; the line may be coarser than boundary.chord\n";
    }
    return out;
}

namespace {
/// A unit of the schema as UDUNITS reads it: [p] is that of the order.
std::string udunits(std::string unit, const physics::Form& form) {
    const std::string order = form.order_is_density ? "(mm^-2)" : "1";
    for (std::size_t at = unit.find("[p]"); at != std::string::npos; at = unit.find("[p]")) unit.replace(at, 3, order);
    return unit;
}

/// The plane itself, whether lines were found in it or not.
files::ResultTable plane_table(const BoundaryReport& report, const std::string& unit_x, const std::string& unit_y) {
    std::vector<double> sharp, sharp_x, sharp_y;
    bool complete = true;
    for (const TracedLines& traced : report.traced) {
        complete = complete && traced.boundary.complete;
        for (const numerics::PlanePoint& point : traced.boundary.sharp) {
            sharp.push_back(static_cast<double>(sharp.size()));
            sharp_x.push_back(point.x);
            sharp_y.push_back(point.y);
        }
    }
    files::ResultTable table{
        .group = "/plane",
        .axes = {},
        .quantities = {{"x_from", unit_x, "least " + report.x.name, {}},
                       {"x_to", unit_x, "largest " + report.x.name, {}},
                       {"y_from", unit_y, "least " + report.y.name, {}},
                       {"y_to", unit_y, "largest " + report.y.name, {}},
                       {"complete", "1", "1: every line is refined to boundary.chord", {}}},
        .values = {{report.x.from}, {report.x.to}, {report.y.from}, {report.y.to}, {complete ? 1.0 : 0.0}}};
    if (sharp.empty()) return table;
    table.axes.push_back({"sharp", "1", "cusps, double points and corners that are not resolved further", sharp});
    table.quantities.push_back({"sharp_x", unit_x, report.x.name, {"sharp"}});
    table.quantities.push_back({"sharp_y", unit_y, report.y.name, {"sharp"}});
    table.values.push_back(sharp_x);
    table.values.push_back(sharp_y);
    return table;
}

/// The vertices of all lines, one line after the other.
files::ResultTable line_table(const BoundaryReport& report, const std::string& unit_x, const std::string& unit_y) {
    files::ResultTable table{.group = "/boundary",
                             .axes = {{"vertex", "1", "vertices of all lines, one line after the other", {}}},
                             .quantities = {},
                             .values = {}};
    std::vector<double>& vertices = table.axes.front().values;
    std::vector<std::vector<double>>& columns = table.values;
    for (const auto& [name, unit, meaning] :
         {std::tuple<std::string, std::string, std::string>{"line", "1", "number of the line"},
          {"limit", "1", "what is lost: 0 onset, 1 phase-separation, 2 banding, 3 oblique"},
          {"convention", "1", "of lambda: 0 mean, 1 single-rod"},
          {"closed", "1", "1: the line ends where it begins"},
          {"x", unit_x, report.x.name},
          {"y", unit_y, report.y.name},
          {"error_x", unit_x,
           "standard error of the line's place, its part along x: a shift along the gradient in the plane laid on a "
           "square"},
          {"error_y", unit_y, "the same, its part along y"},
          {"angle", "degree", "angle to p0 of the wave that decides"}}) {
        table.quantities.push_back({name, unit, meaning, {"vertex"}});
        columns.emplace_back();
    }
    double line_number = 0.0;
    for (const TracedLines& traced : report.traced)
        for (const physics::BoundaryLine& line : traced.boundary.lines) {
            for (const physics::BoundaryPoint& point : line.points) {
                vertices.push_back(static_cast<double>(vertices.size()));
                const double row[]{line_number,
                                   static_cast<double>(traced.limit),
                                   traced.convention == "single-rod" ? 1.0 : 0.0,
                                   line.closed ? 1.0 : 0.0,
                                   point.x,
                                   point.y,
                                   point.error_x,
                                   point.error_y,
                                   point.angle / degree};
                for (std::size_t c = 0; c < columns.size(); ++c) columns[c].push_back(row[c]);
            }
            line_number += 1.0;
        }
    return table;
}

files::ResultTable map_table(const BoundaryReport& report, const std::string& unit_x, const std::string& unit_y) {
    std::vector<double> regimes;
    for (const Regime regime : report.regimes) regimes.push_back(static_cast<double>(regime));
    const std::vector<std::string> plane{"map_y", "map_x"};
    return {.group = "/map",
            .axes = {{"map_y", unit_y, report.y.name, report.map_y}, {"map_x", unit_x, report.x.name, report.map_x}},
            .quantities = {{"regime", "1",
                            "-1 not defined, 0 isotropic, 1 isotropic and separating, 2 flock, 3 flock that bands, 4 "
                            "flock that breaks "
                            "obliquely",
                            plane},
                           {"effective_relaxation", "s-1", "abar = a - lambda alpha/Gamma", plane}},
            .values = {regimes, report.effective_relaxation}};
}
}  // namespace

std::vector<files::ResultTable> boundary_tables(const BoundaryReport& report) {
    const physics::Form form = physics::form(report.scene.model);
    const std::string unit_x = udunits(report.x.unit, form), unit_y = udunits(report.y.unit, form);
    std::vector<files::ResultTable> tables{plane_table(report, unit_x, unit_y)};
    files::ResultTable lines = line_table(report, unit_x, unit_y);
    if (!lines.axes.front().values.empty()) tables.push_back(std::move(lines));
    if (!report.map_x.empty()) tables.push_back(map_table(report, unit_x, unit_y));
    return tables;
}

}  // namespace drover::run
