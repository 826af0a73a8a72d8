// run/boundary_plan.cpp: from the text of a plane to its axes.
#include "run/boundary_plan.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/log.hpp"
#include "drover/physics/regimes.hpp"
#include "run/number_lists.hpp"

namespace drover::run {

namespace {
void check_range(const std::string& list, const std::string& written, const Range& range, double value,
                 const SourceLocation& where) {
    const bool low = range.min_open ? value <= range.min : value < range.min;
    require(!low && value <= range.max, where, "{} has \"{}\": {} is out of the range of its key; expected {} {}{}",
            list, written, value, range.min_open ? ">" : ">=", range.min,
            std::isfinite(range.max) ? text(" and <= {}", range.max) : "");
}

/// The model does not read a number that its table replaces.
void check_not_tabulated(const physics::Model& model, const std::string& list, const std::string& key,
                         const SourceLocation& where) {
    const physics::Equations equations(model);
    for (const auto& [number, coefficient] : named(equations))
        require(key != number || coefficient->table() == nullptr, where,
                "{} names {}, which the scene takes from its table; choose a number that the model reads", list, key);
}

void check_affects_boundaries(const std::string& list, const std::string& key, const SourceLocation& where) {
    require(physics::affects_boundaries(key), where,
            "{} names {}, which does not affect phase boundaries; choose another number", list, key);
}

physics::PlaneAxis area_fraction_axis(const io::Scene& scene, const physics::AreaFraction& fraction,
                                      const std::string& list, const std::string& written, double from, double to) {
    const double area = scene.model.uniform.*fraction.area;
    require(area > 0.0, io::location_of(scene, fraction.area_key),
            "{} has \"{}\", which needs the area of one particle, and {} = {}; expected > 0 [mm^2]", list, written,
            fraction.area_key, area);
    require(from > 0.0, io::location_of(scene, list), "{} has \"{}\"; expected area fractions above 0", list, written);
    return physics::area_fraction_axis(fraction, area, from, to);
}

physics::PlaneAxis axis_of(const io::Scene& scene, const std::string& list, const std::string& written) {
    const SourceLocation where = io::location_of(scene, list);
    const auto [key, from, to] = read_axis(list, written, "\"driving.strength = 0.5:2\"", where);
    if (const physics::AreaFraction* fraction = physics::find_area_fraction(key))
        return area_fraction_axis(scene, *fraction, list, written, from, to);
    const io::ModelNumber number = io::model_number(key, where, scene.model);
    check_not_tabulated(scene.model, list, key, where);
    check_affects_boundaries(list, key, where);
    check_range(list, written, number.range, from, where);
    check_range(list, written, number.range, to, where);
    return {.name = key,
            .unit = number.unit.empty() ? "1" : number.unit,
            .from = from,
            .to = to,
            .set = [in = number.in](physics::Model& model, double held) { in(model) = held; },
            .is_density = physics::density_axis(key) != physics::DensityAxis::none};
}

std::vector<physics::Uncertain> uncertain_numbers(const io::Scene& scene, const physics::Plane& plane) {
    std::vector<physics::Uncertain> result = physics::table_errors(scene.model);
    const std::string list = "boundary.errors", example = "\"relaxation.rate = 0.02\"";
    const SourceLocation where = io::location_of(scene, list);
    for (const std::string& written : scene.boundary.errors) {
        const auto [key, value] = read_assignment(written, list, example, where);
        const double error = read_number(value, written, list, example, where);
        require(error > 0.0, where, "{} has \"{}\"; expected a standard error > 0", list, written);
        for (const physics::PlaneAxis* axis : {&plane.x, &plane.y})
            require(!physics::is_same_axis(key, axis->name), where,
                    "{} names {}, which the axis {} of the plane sets exactly; expected another number", list, key,
                    axis->name);
        const io::ModelNumber number = io::model_number(key, where, scene.model);
        if (io::is_from_table(scene, key)) {
            log_warning("{} names {}, whose error is that of {}; its error here is not used", list, key,
                        scene.calibrated.table);
            continue;
        }
        check_not_tabulated(scene.model, list, key, where);
        check_affects_boundaries(list, key, where);
        result.push_back({.name = key, .error = error, .add = [in = number.in](physics::Model& model, double change) {
                              in(model) += change;
                          }});
    }
    return result;
}

std::vector<std::string> conventions_of(const io::Scene& scene) {
    const std::string& of_scene = scene.model.weathercock.convention;
    if (scene.boundary.conventions.empty()) return {of_scene};
    if (io::is_from_table(scene, "weathercock.strength"))
        for (const std::string& convention : scene.boundary.conventions)
            require(convention == of_scene, io::location_of(scene, "boundary.conventions"),
                    "boundary.conventions has \"{}\", but lambda comes from a table in the convention "
                    "weathercock.convention = \"{}\"; expected that one: choose by weathercock.convention",
                    convention, of_scene);
    return scene.boundary.conventions;
}
}  // namespace

const std::vector<std::string>& line_names() {
    using physics::Limit;
    static const std::vector<std::string> names{physics::limit_name(Limit::onset),
                                                physics::limit_name(Limit::phase_separation),
                                                physics::limit_name(Limit::banding),
                                                physics::limit_name(Limit::oblique), binodal_name};
    return names;
}

KeyRange read_axis(const std::string& list, const std::string& written, const std::string& example,
                   const SourceLocation& where) {
    require(!written.empty(), where,
            "{} is not given; expected a number of the model and its range, such as {}: set it in the scene, or by "
            "--{}",
            list, example, list.substr(list.find('.') + 1));
    const auto [key, value] = read_assignment(written, list, example, where);
    const std::vector<std::string> ends = split(value, ':');
    require(ends.size() == 2, where, "{} has \"{}\"; expected first:last, as in {}", list, written, example);
    const KeyRange axis{.key = key,
                        .from = read_number(ends[0], written, list, example, where),
                        .to = read_number(ends[1], written, list, example, where)};
    require(axis.from < axis.to, where, "{} has \"{}\"; expected the smaller number first", list, written);
    return axis;
}

PlannedBoundary plan_boundary(const io::Scene& scene) {
    const io::BoundaryPlan& plan = scene.boundary;
    PlannedBoundary planned{.plane = {.model = scene.model,
                                      .x = axis_of(scene, "boundary.x", plan.x),
                                      .y = axis_of(scene, "boundary.y", plan.y)},
                            .uncertain = {},
                            .conventions = {},
                            .limits = {},
                            .has_binodal = false};
    const physics::Plane& plane = planned.plane;
    require(!physics::is_same_axis(plane.x.name, plane.y.name), io::location_of(scene, "boundary.y"),
            "boundary.x is {} and boundary.y is {}; expected two different numbers", plane.x.name, plane.y.name);
    require(!plan.lines.empty(), io::location_of(scene, "boundary.lines"),
            "boundary.lines is empty; expected at least one of {}", joined(line_names()));
    planned.uncertain = uncertain_numbers(scene, plane);
    planned.conventions = conventions_of(scene);
    for (const std::string& name : plan.lines) {
        require(std::find(line_names().begin(), line_names().end(), name) != line_names().end(),
                io::location_of(scene, "boundary.lines"),
                "boundary.lines has \"{}\", a line of models of their own; expected one of {}", name,
                joined(line_names()));
        if (name == binodal_name) planned.has_binodal = true;
        else planned.limits.push_back(physics::limit_of(name));
    }
    return planned;
}

}  // namespace drover::run
