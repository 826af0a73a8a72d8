// analysis/boundary_plan.cpp: from the text of a plane to its axes.
#include "analysis/boundary_plan.hpp"

#include <algorithm>
#include <cmath>

#include "base/log.hpp"
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

}  // namespace drover::analysis
