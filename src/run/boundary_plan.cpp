// run/boundary_plan.cpp: from the text of a plane to its axes.
#include "run/boundary_plan.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/log.hpp"
#include "drover/physics/regimes.hpp"
#include "run/binodal_lines.hpp"
#include "run/number_lists.hpp"
#include "run/scene_equations.hpp"

namespace drover::run {

namespace {
void check_range(const std::string& list, const std::string& written, const Range& range, double value,
                 const SourceLocation& where) {
    const bool low = range.min_open ? value <= range.min : value < range.min;
    require(!low && value <= range.max, where, "{} has \"{}\": {} is out of the range of its key; expected {} {}{}",
            list, written, value, range.min_open ? ">" : ">=", range.min,
            std::isfinite(range.max) ? text(" and <= {}", range.max) : "");
}

/// Rods and beads do not read a number that their table replaces, nor noise in boundaries.
void check_is_read(const physics::Model& model, const std::string& list, const std::string& key,
                   const SourceLocation& where) {
    const physics::Equations equations(model);
    for (const auto& [number, coefficient] : named(equations))
        require(key != number || coefficient->table() == nullptr, where,
                "{} names {}, which the scene takes from its table; choose a number that the model reads", list, key);
    require(physics::affects_boundaries(key), where,
            "{} names {}, which does not affect phase boundaries; choose another number", list, key);
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
    const auto [key, value] = read_assignment(written, list, example, where);
    const std::vector<std::string> ends = split(value, ':');
    require(ends.size() == 2, where, "{} has \"{}\"; expected first:last, as in {}", list, written, example);
    const KeyRange axis{.key = key,
                        .from = read_number(ends[0], written, list, example, where),
                        .to = read_number(ends[1], written, list, example, where)};
    require(axis.from < axis.to, where, "{} has \"{}\"; expected the smaller number first", list, written);
    return axis;
}

/// A unit of the schema as UDUNITS text: [p] is the unit of the order.
std::string udunits(std::string unit, const physics::Form& form) {
    const std::string order = form.order_is_density ? "(mm^-2)" : "1";
    for (std::size_t at = unit.find("[p]"); at != std::string::npos; at = unit.find("[p]")) unit.replace(at, 3, order);
    return unit;
}

DescribedAxis axis_of(const io::Scene& scene, const std::string& list, const std::string& written) {
    const SourceLocation where = io::location_of(scene, list);
    const bool is_own = scene.kind == io::SceneKind::model;
    const auto [key, from, to] =
        read_axis(list, written, is_own ? "\"coefficients.a = 0.5:2\"" : "\"driving.strength = 0.5:2\"", where);
    DescribedAxis axis{.name = key, .unit = "1", .udunits = "1", .from = from, .to = to};
    if (const physics::AreaFraction* fraction = physics::find_area_fraction(key); fraction != nullptr && !is_own) {
        const double area = scene.model.uniform.*fraction->area;
        require(area > 0.0, io::location_of(scene, fraction->area_key),
                "{} has \"{}\", which needs the area of one particle, and {} = {}; expected > 0 [mm^2]", list, written,
                fraction->area_key, area);
        require(from > 0.0, where, "{} has \"{}\"; expected area fractions above 0", list, written);
        return axis;
    }
    const SceneNumber number = number_of(scene, list, key, where);
    axis.name = number.key;
    if (is_own) return axis;
    axis.unit = number.unit;
    axis.udunits = udunits(number.unit, physics::form(scene.model));
    check_is_read(scene.model, list, key, where);
    const Range range = io::model_number(key, where, scene.model).range;
    check_range(list, written, range, from, where);
    check_range(list, written, range, to, where);
    return axis;
}

std::vector<std::pair<std::string, double>> errors_of(const io::Scene& scene, const PlannedBoundary& planned) {
    std::vector<std::pair<std::string, double>> errors;
    const bool is_own = scene.kind == io::SceneKind::model;
    const std::string list = "boundary.errors",
                      example = is_own ? "\"coefficients.a = 0.02\"" : "\"relaxation.rate = 0.02\"";
    const SourceLocation where = io::location_of(scene, list);
    for (const std::string& written : scene.boundary.errors) {
        const auto [given, value] = read_assignment(written, list, example, where);
        const double error = read_number(value, written, list, example, where);
        require(error > 0.0, where, "{} has \"{}\"; expected a standard error > 0", list, written);
        const std::string key = number_of(scene, list, given, where).key;
        for (const DescribedAxis* axis : {&planned.x, &planned.y})
            require(!physics::is_same_axis(key, axis->name), where,
                    "{} names {}, which the axis {} of the plane sets exactly; expected another number", list, key,
                    axis->name);
        if (!is_own && io::is_from_table(scene, key)) {
            log_warning("{} names {}, whose error is that of {}; its error here is not used", list, key,
                        scene.calibrated.table);
            continue;
        }
        if (!is_own) check_is_read(scene.model, list, key, where);
        errors.emplace_back(key, error);
    }
    return errors;
}

std::vector<std::string> conventions_of(const io::Scene& scene) {
    if (scene.kind == io::SceneKind::model) {
        require(scene.boundary.conventions.empty(), io::location_of(scene, "boundary.conventions"),
                "boundary.conventions is for the equations of rods and beads; expected a scene without it");
        return {};
    }
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

std::vector<std::string> lines_in(const io::Scene& scene) {
    const bool is_own = scene.kind == io::SceneKind::model;
    const bool has_spin = std::any_of(scene.declared.fields.begin(), scene.declared.fields.end(),
                                      [](const io::DeclaredField& field) { return field.rank != "scalar"; });
    if (is_own && scene.boundary.lines == io::BoundaryPlan{}.lines)
        return has_spin ? line_names(scene.kind) : std::vector<std::string>{"isotropic"};
    const std::vector<std::string>& known = line_names(scene.kind);
    const SourceLocation where = io::location_of(scene, "boundary.lines");
    std::vector<std::string> lines = scene.boundary.lines;
    require(!lines.empty(), where, "boundary.lines is empty; expected at least one of {}", joined(known));
    for (const std::string& name : lines) {
        require(std::find(known.begin(), known.end(), name) != known.end(), where,
                "boundary.lines has \"{}\", a line of {}; expected one of {}{}", name,
                is_own ? "rods and beads" : "models of their own", joined(known),
                is_own ? " for a model of its own: where that state becomes unstable" : "");
        require(name != "ordered" || has_spin, where,
                "boundary.lines has \"ordered\", and no field of the model has a direction; expected isotropic");
    }
    std::stable_partition(lines.begin(), lines.end(), [](const std::string& name) { return name != binodal_name; });
    return lines;
}
}  // namespace

const std::vector<std::string>& line_names(io::SceneKind kind) {
    using physics::Limit;
    static const std::vector<std::string> limits{physics::limit_name(Limit::onset),
                                                 physics::limit_name(Limit::phase_separation),
                                                 physics::limit_name(Limit::banding),
                                                 physics::limit_name(Limit::oblique), binodal_name},
        states{"isotropic", "ordered"};
    return kind == io::SceneKind::model ? states : limits;
}

PlannedBoundary plan_boundary(const io::Scene& scene) {
    PlannedBoundary planned{.x = axis_of(scene, "boundary.x", scene.boundary.x),
                            .y = axis_of(scene, "boundary.y", scene.boundary.y)};
    require(!physics::is_same_axis(planned.x.name, planned.y.name), io::location_of(scene, "boundary.y"),
            "boundary.x is {} and boundary.y is {}; expected two different numbers", planned.x.name, planned.y.name);
    planned.errors = errors_of(scene, planned);
    planned.conventions = conventions_of(scene);
    planned.lines = lines_in(scene);
    if (planned.lines.back() == binodal_name) check_binodal_plane(scene, planned.x.name, planned.y.name);
    return planned;
}

}  // namespace drover::run
